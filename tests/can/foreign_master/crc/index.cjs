// SPDX-License-Identifier: Apache-2.0
'use strict';
const { crc16xmodem } = require('crc');

// canopen asks for one polynomial only, that of CiA 301 (7.2.4.3.16): x^16 + x^12 + x^5 + 1, begun at zero.
exports.crc = (bits, reflected, polynomial, ...rest) => {
  const data = rest.pop();
  if (bits !== 16 || reflected || polynomial !== 0x1021 || rest.some((value) => value !== 0)) throw new Error('another CRC');
  const result = Buffer.alloc(2);
  result.writeUInt16BE(crc16xmodem(data));
  return result;
};
