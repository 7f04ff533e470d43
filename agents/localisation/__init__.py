"""Where a robot is, as far as it knows: the set that holds its true place, from measurements and odometry."""
