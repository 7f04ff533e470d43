"""What commands do to disks: integrators with imperfect actuation."""
