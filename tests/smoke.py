"""Use a wheel in a clean environment: the extension, a run in virtual time, one in real time."""

import asap

scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
tracker = asap.ClusterTracker(scene.width, scene.height)
for run in (
    asap.simulate(scene, cost=asap.LinearCost(100, 300), algorithm=tracker),
    asap.run(scene, algorithm=tracker, latency_ms=10),
):
    ledger = run.summary()["ledger"]
    assert ledger["delivered"] > 0, ledger
    print(run)
