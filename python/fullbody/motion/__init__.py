"""Systems, their integration by simulations, and the runs that result, with saving and loading."""
