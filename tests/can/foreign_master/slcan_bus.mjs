// SPDX-License-Identifier: Apache-2.0
// A CAN bus on a terminal: the ASCII protocol of the Lawicel CANUSB, as slcand speaks it.
import {execFileSync} from 'node:child_process';
import fs from 'node:fs';
import tty from 'node:tty';

export class SlcanBus {
  /// `receive`: called with {id, data} for each classic frame with an 11-bit identifier.
  constructor(terminal, receive) {
    execFileSync('stty', ['-F', terminal, 'raw', '-echo']);
    this.file = fs.openSync(terminal, fs.constants.O_RDWR | fs.constants.O_NOCTTY);
    this.input = new tty.ReadStream(this.file);
    this.rest = '';
    this.input.on('data', (bytes) => {
      const lines = (this.rest + bytes.toString('latin1')).split('\r');
      this.rest = lines.pop();
      for (const line of lines) {
        const frame = /^\x07*z?t([0-9A-Fa-f]{3})([0-8])((?:[0-9A-Fa-f]{2})*)/.exec(line);
        if (frame) receive({id: parseInt(frame[1], 16), data: Buffer.from(frame[3].slice(0, 2 * Number(frame[2])), 'hex')});
      }
    });
    this.write('C\rO\r');
  }
  send({id, data}) {
    this.write(`t${id.toString(16).padStart(3, '0')}${data.length}${Buffer.from(data).toString('hex')}\r`.toUpperCase().replace(/^T/, 't'));
  }
  write(text) {
    fs.writeSync(this.file, text);
  }
  close() {
    this.input.destroy();
  }
}
