/** What keys and words of the project mean, where a form or a table has them. */
export const hints = {
  profile:
    '“owen-kc1” has the rules and the limits of that controller and its IDE. “generic” has the limits of ' +
    'Modbus only.',
  'line.transport':
    'How the line is connected. Takt is the master here: it asks the devices. A simulated line has no ' +
    'hardware: the program invents the answers.' +
    ' The slot is its number among the lines and servers.',
  'server.transport': 'How masters reach this server. Takt is the slave here: it answers other programs.',
  framing:
    'The form of frames on the wire: RTU is binary, ASCII has hexadecimal characters, TCP is for networks.',
  order:
    'Which request is sent first when several are due: the one with the nearest deadline, or by address.',
  attempts: 'Failures in a row after which the device counts as not answering.',
  turnaround:
    'The longest time from the end of a request to the begin of its response. The proof of ages needs it. ' +
    '“learn”: the program measures it.',
  deadline: 'How old a value may become. Without one, the period is the deadline.',
  backoff: 'The pause before a device that does not answer is asked again.',
  status: 'An integer standard variable. It gets the number of the state of the last request.',
  poll_enable: 'A Boolean standard variable. While it is 0, nothing is polled.',
  group_requests: 'Yes: neighbouring variables share a request. No: each variable has a request of its own.',
  registers_per_request: 'A request has at most this many registers.',
  strategy:
    'How requests are formed. Single: one for each variable. Classic: by the rules of the IDE. Optimal: ' +
    'with the least time on the line.',
  gaps:
    'Whether a request may also read registers between its variables. “Learn”: the program tries first ' +
    'whether the device answers.',
  readable: 'Ranges that may be read to join requests, also where no variable is.',
  no_read: 'Ranges that are never read to join requests.',
  offers: 'Ranges that the device has. A variable outside them is a warning.',
  write_single:
    'Whether one coil or one register is written by the functions 0x05 and 0x06, or as a block by 0x0F ' +
    'and 0x10.',
  fc22: 'The device has the function 0x16: it changes single bits of a register.',
  fc23: 'The device has the function 0x17: it writes and reads in one request.',
  read_modify_write:
    'A bit is written by reading its register and writing it back. A change in between is lost.',
  notation: 'How a table writes classic register numbers such as 40001.',
  high_byte_first: 'Within a register: the high byte is sent first, as usual in Modbus.',
  high_register_first: 'In values of several registers: the register with the high part comes first.',
  byte_order: 'The order of the bytes on the wire. Byte 1 is the least significant one.',
  register: 'The address on the wire: it begins with 0. The classic number 40001 is the holding register 0.',
  coil: 'The address of a coil or discrete input. Bit B of register R is the coil 16 × R + B.',
  reference: 'The classic number, which begins with 1: 40108 is the holding register 107.',
  bit: 'A bit of the register: 0 is the least significant one.',
  read: '0x01 coils, 0x02 discrete inputs, 0x03 holding registers, 0x04 input registers.',
  write: '0x05 one coil, 0x06 one register, 0x0F several coils, 0x10 several registers.',
  write_on_change: 'The value is written as soon as the project sets another one.',
  read_trigger: 'A Boolean variable. When it changes from 0 to 1, the value is read at once.',
  write_trigger: 'A Boolean variable. When it changes from 0 to 1, the value is written at once.',
  period: 'How often the value is read. Empty: as the device.',
  max_age: 'An older value counts as uncertain.',
  min_interval: 'The least mean time between two writes on change.',
  burst: 'How many writes may follow each other at once.',
  default: 'The value until one is read, and while the device does not answer.',
  hold_last: 'While the device does not answer, the last value stays instead of the default.',
  retain: 'The value is kept over a restart of the program.',
  used: 'No: the variable causes no requests.',
  dead_band: 'A change by no more than this is not reported.',
  verify: 'After a write the value is read back and compared.',
};
