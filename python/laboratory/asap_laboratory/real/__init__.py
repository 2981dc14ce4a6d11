"""The cluster tracker on recordings with boxes: one table, one page of overlays."""

__all__ = ["conduct", "document", "folders", "following", "mistakes", "page", "pictures"]
