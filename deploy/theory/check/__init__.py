"""What `disknav check` says of a scenario: theory, and what is seen in practice."""
