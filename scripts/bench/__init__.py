"""The Python side of lcpbench: statistics, figures and the report, made from the rows of a campaign."""
