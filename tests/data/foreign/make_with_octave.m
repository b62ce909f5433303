% SPDX-License-Identifier: Apache-2.0
% The files of Octave in this folder, written anew: octave-cli make_with_octave.m
t = (0:1199)' * 0.002;
x = 0.0125 + 0.003 * sin(2 * pi * 1.5 * t);
F = 4 * sign(cos(2 * pi * 1.5 * t)) + 20 * x;
dlmwrite('octave_dlmwrite.txt', [t x F], 'delimiter', '\t', 'precision', '%.7g');
time_s = t; position_m = x; force_N = F;
save('-v7', 'octave_v7.mat', 'time_s', 'position_m', 'force_N');
save('-hdf5', 'octave.h5', 'time_s', 'position_m', 'force_N');
