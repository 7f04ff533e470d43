"""What a robot computes: navigation function, velocity law, separating lines, estimate, its process."""
