"""What a body adds to the filter: what it still passes if it hears nothing, which velocities are safe."""
