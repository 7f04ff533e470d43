"""Kinematics of bodies: a robot's filter predicts with them, and a plant executes them."""
