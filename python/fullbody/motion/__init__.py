"""The verbs: systems that are integrated, simulations that go on, runs that are drawn, saved and loaded."""
