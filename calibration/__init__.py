"""Calibration: search the parameters that the papers leave open, from a checkout.

The results are the defaults of scenarios and controllers. Run `python -m calibration --help`; the
extra `calibrate` brings what it needs.
"""
