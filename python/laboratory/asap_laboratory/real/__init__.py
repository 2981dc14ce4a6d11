"""The cluster tracker on recordings with boxes: one table, one page of overlays."""
