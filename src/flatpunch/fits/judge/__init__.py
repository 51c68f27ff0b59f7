"""What a measured curve shows: its approach, the force without contact, the contact, and the range that a model describes."""
