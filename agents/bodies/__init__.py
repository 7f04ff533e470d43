"""What a body adds to the filter: what it still passes when it hears nothing, and which velocities are safe."""
