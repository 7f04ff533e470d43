"""The navigation function of Karagoz, Bozma, Koditschek over whole configurations, and its theory."""
