"""Systems that integrate, simulations that go on, runs that are drawn, saved and loaded."""
