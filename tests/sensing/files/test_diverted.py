"""A message of one thread is there, while another thread holds back what a decoder says."""

from __future__ import annotations

import subprocess
import sys

import cv2
import numpy as np

PROGRAM = """
import sys, threading
from plogic.face.shown.printed import open_streams, say
from sensing.files.images import image_from
from sensing.simulated.physics import quiet

open_streams()
data = open(sys.argv[1], "rb").read()

def decode():
    for _ in range(30):
        image_from(data, "picture")
        with quiet():
            pass

thread, number = threading.Thread(target=decode), 0
thread.start()
while thread.is_alive():
    say(f"line {number}")
    number += 1
print(number)
"""


def test_no_message_is_lost_while_a_decoder_is_held_back(tmp_path):
    picture = tmp_path / "picture.png"
    cv2.imwrite(str(picture), np.zeros((300, 300, 3), np.uint8))
    command = [sys.executable, "-c", PROGRAM, str(picture)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.stderr.splitlines() == [f"line {number}" for number in range(int(done.stdout))]
    assert int(done.stdout) > 30


def test_a_copy_of_the_process_can_speak():
    program = """
import os, sys, threading, time
from geometry.diverted import DIVERTED
threading.Thread(target=lambda: [(DIVERTED.acquire(), time.sleep(0.001), DIVERTED.release()) for _ in range(300)]).start()
for _ in range(30):
    child = os.fork()
    if not child:
        with DIVERTED:
            os._exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")
