"""Prints `high_bands` of goldens.json: [l, m, theta, y_l^m at (theta, phi = 0)], computed to 400 digits by mpmath.

    y_l^m = (-1)^m sqrt((2 - [m = 0]) (2l+1)/(4 pi) (l+m)!/(l-m)!) / (2^m m!) sin^m(theta)
            2F1(m - l, l + m + 1; m + 1; sin^2(theta/2))
"""
import json

from mpmath import factorial, hyp2f1, mp, mpf, pi, sin, sqrt

mp.dps = 400


def y(l, m, theta):
    norm = sqrt((1 if m == 0 else 2) * (2 * l + 1) / (4 * pi) * factorial(l + m) / factorial(l - m))
    series = hyp2f1(m - l, l + m + 1, m + 1, sin(theta / 2) ** 2)
    return (-1) ** m * norm / (2**m * factorial(m)) * sin(theta) ** m * series


bands = [(64, 0), (64, 40), (100, 99), (127, 3), (127, 90), (128, 128), (200, 150), (255, 0), (255, 1), (255, 94), (255, 200), (255, 255)]
angles = [1e-6, 0.001, 0.02, 0.1, 0.35, 0.8, 1.3, 1.5707]
values = [[l, m, theta, float(y(l, m, mpf(theta)))] for l, m in bands for theta in angles]
print(json.dumps([v for v in values if abs(v[3]) > 1e-290], indent=1))
