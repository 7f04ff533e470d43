"""A fleet as Foxglove's 3D panel and ROS tools read it, made of a run's messages."""
