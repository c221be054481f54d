"""The one script: compose the configuration, run the task it names. `python train.py --help` shows the choices."""

from lssd_learn.__main__ import main

if __name__ == "__main__":
    main()
