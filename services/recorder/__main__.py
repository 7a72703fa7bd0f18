"""Run the recorder: ``python -m services.recorder``."""

from bus.service import serve
from services.recorder.config import RecorderConfig
from services.recorder.service import main

serve(main, RecorderConfig, name="recorder", package=__package__, never_interrupts=True)
