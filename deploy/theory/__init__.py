"""Theory of the navigation function of Karagoz, Bozma, Koditschek, for whole configurations."""
