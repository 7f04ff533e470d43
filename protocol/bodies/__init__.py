"""How bodies move: the kinematics that a robot's filter predicts with, and that a plant executes."""
