"""The cluster tracker beside its rivals, over scenes."""
