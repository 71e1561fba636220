"""The constrained backlash-signature fit of a recording of motor speed, and the calibration that turns it into rad."""
