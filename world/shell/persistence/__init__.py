"""What a world keeps of a run, so that it can go on from there: its journal, snapshots, and their replay."""
