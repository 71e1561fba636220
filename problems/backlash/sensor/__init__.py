"""The virtual sensor: from a recording of a motor's speed to the backlash of its joint (thesis chapters 5, 7 and 8)."""
