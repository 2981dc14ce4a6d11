"""What the algorithms get right, over scenes and the fraction of events kept."""
