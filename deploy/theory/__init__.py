"""Theory of the navigation function of Karagöz, Bozma, Koditschek, for whole configurations."""
