// SPDX-License-Identifier: Apache-2.0
/** The CRC of SDO block transfer (CiA 301, 7.2.4.3.16), as the package node-crc returns it. */
exports.crc = (bits, isReflected, polynomial, polynomialHigh, initial, initialHigh, final, finalHigh, data) => {
  let crc = initial;
  for (const byte of data) {
    crc ^= byte << 8;
    for (let bit = 0; bit < 8; ++bit) crc = crc & 0x8000 ? (crc << 1) ^ polynomial : crc << 1;
  }
  const result = Buffer.alloc(2);
  result.writeUInt16BE((crc ^ final) & 0xffff);
  return result;
};
