"""The cluster tracker beside its rivals, over scenes."""

__all__ = ["cases", "conduct", "cost", "document"]
