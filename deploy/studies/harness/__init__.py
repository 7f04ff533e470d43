"""What every study is made and run with: cells of seeded runs, statistics over them, runners."""
