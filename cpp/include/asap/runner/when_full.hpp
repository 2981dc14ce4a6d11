// WhenFull: what gives way when live events come faster than they leave the ring.
#pragma once

namespace asap {

enum class WhenFull {
  // Beyond three quarters, the more the ring fills the fewer events of a push get in, by chance:
  // the thinning stays uniform, whatever the size of a push, and counts as discarded. Only a push
  // that finds the ring full, because nobody empties it, is overflow. See Intake.
  thin,
  newest,  // what does not fit is dropped
  oldest,  // finding the ring full, the consumer drops the older half
  block,   // the producer waits for room: only for sources that can wait, such as files
};

}  // namespace asap
