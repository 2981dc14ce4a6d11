"""What a camera itself leaves out: a region of its sensor, events above a rate."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from asap import _checks

_PERIOD_US = 1000  # in which a camera counts


def configuration(
    driver: Any, device: Any, region: tuple[int, int, int, int] | None, rate_bound: float | None
) -> Any:
    """Return the driver's configuration of a listed device, with a region, a rate or both.

    Raises
    ------
    ValueError
        The camera cannot do that, or it does not fit its sensor.
    """
    module = getattr(driver, device.name.name.lower())
    made = module.Configuration()
    has = {field.name for field in fields(made)}
    properties, name = module.Properties, device.name.value
    if region is not None:
        left, top, width, height = _region(region, properties.width, properties.height)
        if "region_of_interest" in has:
            made.region_of_interest = module.RegionOfInterest(left, top, width, height)
        elif "x_mask" in has:
            mask = driver.RowColumnMask(properties.width, properties.height, set=True)
            mask.clear_rectangle(left, top, width, height)
            made.x_mask, made.y_mask = mask.x_mask(), mask.y_mask()
        else:
            remedy = f"the driver knows no region of {name}; leave it out"
            raise ValueError(_checks.named("region", region, remedy))
    if rate_bound is not None:
        remedy = "give the most events per second, 1e4 to 1e9"
        rate = _checks.number("rate_bound", rate_bound, 1e4, 1e9, remedy)
        if "rate_limiter" not in has:
            remedy = f"the driver knows no limit of {name}; asap.Asap2020 has one for any camera"
            raise ValueError(_checks.named("rate_bound", rate_bound, remedy))
        most = round(rate * _PERIOD_US * 1e-6)
        made.rate_limiter = module.RateLimiter(_PERIOD_US, most)
    return made


def _region(region: Any, width: int, height: int) -> tuple[int, int, int, int]:
    try:
        left, top, w, h = (side.__index__() for side in region)
        if min(left, top) >= 0 and min(w, h) >= 1 and left + w <= width and top + h <= height:
            return left, top, w, h
    except (TypeError, ValueError, AttributeError):
        pass
    remedy = f"give (left, top, width, height), whole px of the {width} x {height} of the sensor"
    raise ValueError(_checks.named("region", region, remedy))
