"""The mutual events of (22) Kalliope and Linus in the light curves of November 2021."""
