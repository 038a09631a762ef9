"""What Python runs when it is given the folder that holds this file and the package."""

import sys

from qrobot_release.program import main

sys.exit(main())
