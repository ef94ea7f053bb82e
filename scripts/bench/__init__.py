"""The Python side of lcpbench: statistics, figures and the report, made from the rows of a
campaign."""

import signal

# A reader that has seen enough (`recommend ... | head`) ends the program as it ends any other,
# without a traceback.
signal.signal(signal.SIGPIPE, signal.SIG_DFL)
