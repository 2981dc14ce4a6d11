"""Every consumer of the library on one stream that overloads the slow ones."""

__all__ = [
    "accuracy",
    "cases",
    "conduct",
    "cost",
    "document",
    "figures",
    "naive",
    "results",
    "rungs",
    "settings",
]
