"""Views of a run: live page, terminal, 3D scene, recording and plot."""
