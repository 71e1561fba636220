"""The virtual sensor: from recordings of motor speed to the backlash of joints, their trend, and pictures of both."""
