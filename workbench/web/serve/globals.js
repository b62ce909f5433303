// SPDX-License-Identifier: Apache-2.0
// What units.js reads of a page: the units of a rotary axis, where the logs are of one.
const report = {};
