"""What Fumagalli's thesis measured on the real iCub, for comparison."""

import numpy as np

# Table 4.1: predicted minus measured F/T reading while the limbs move freely; mean and
# standard deviation of three forces [N] and three moments [N m] in the sensors' frames.
TABLE_4_1 = {
    "l_arm_ft": np.array(
        [
            [-0.0908, -0.4811, 0.8699, 0.0436, 0.0382, 0.0030],
            [0.5742, 0.6677, 0.7920, 0.1048, 0.0702, 0.0332],
        ]
    ),
    "r_arm_ft": np.array(
        [
            [-0.3157, -0.5209, 0.7723, -0.0252, 0.0582, 0.0197],
            [0.5845, 0.7156, 0.7550, 0.0882, 0.0688, 0.0364],
        ]
    ),
    "l_leg_ft": np.array(
        [
            [0.2941, -5.1476, -1.9459, -0.3084, -0.8399, 0.0270],
            [1.8031, 1.8327, 2.3490, 0.3365, 0.8348, 0.0498],
        ]
    ),
    "r_leg_ft": np.array(
        [
            [-1.6678, 3.4476, -1.5505, 0.4050, -0.7340, 0.0171],
            [3.3146, 2.7039, 1.7996, 0.3423, 0.7141, 0.0771],
        ]
    ),
}
