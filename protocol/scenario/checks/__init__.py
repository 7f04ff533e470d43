"""What must hold of a scenario beyond the types of its fields: one file for each thing that is checked."""
