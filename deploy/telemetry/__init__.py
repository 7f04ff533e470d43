"""What is seen of a run: live on a page or in a terminal, as a scene, recorded, drawn from a recording."""
