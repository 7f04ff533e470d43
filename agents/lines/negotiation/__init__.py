"""How lines are proposed and answered: to near peers in States, to far ones in letters."""
