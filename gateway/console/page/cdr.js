// Reads samples as DDS carries them, by the OMG IDL text that came with their channel. Understands the dialect of this
// house: modules, enums, one final struct, scalars, bounded strings and one-dimensional arrays.

const scalars = {
  'boolean': [1, (v, at) => v.getUint8(at) !== 0],
  'octet': [1, (v, at) => v.getUint8(at)],
  'short': [2, (v, at, le) => v.getInt16(at, le)],
  'unsigned short': [2, (v, at, le) => v.getUint16(at, le)],
  'long': [4, (v, at, le) => v.getInt32(at, le)],
  'unsigned long': [4, (v, at, le) => v.getUint32(at, le)],
  'long long': [8, (v, at, le) => v.getBigInt64(at, le)],
  'unsigned long long': [8, (v, at, le) => v.getBigUint64(at, le)],
  'float': [4, (v, at, le) => v.getFloat32(at, le)],
  'double': [8, (v, at, le) => v.getFloat64(at, le)],
};

const utf8 = new TextDecoder();

function withoutPrefix(names) {
  let length = 0;
  for (let end = names[0].indexOf('_') + 1; end > 0; end = names[0].indexOf('_', end) + 1) {
    if (!names.every(name => name.startsWith(names[0].slice(0, end)))) break;
    length = end;
  }
  return names.map(name => name.slice(length).toLowerCase());
}

// The fields of the struct `typeName` ("motionlab::Mru"), in order.
export function parseIdl(text, typeName) {
  const idl = text.replace(/\/\/[^\n]*/g, '').replace(/\/\*[^]*?\*\//g, '');
  const enums = {};
  for (const [, name, body] of idl.matchAll(/enum\s+(\w+)\s*\{([^}]*)\}/g)) {
    enums[name] = withoutPrefix(body.split(',').map(value => value.trim()));
  }
  const struct = typeName.split('::').pop();
  const body = idl.match(new RegExp(`struct\\s+${struct}\\s*\\{([^}]*)\\}`));
  if (!body) throw new Error(`the schema has no struct ${struct}`);
  return body[1].split(';').map(field => field.trim()).filter(Boolean).map(field => {
    const found = field.match(/^(@key\s+)?(.+?)\s+(\w+)(?:\[(\d+)\])?$/s);
    if (!found) throw new Error(`not understood: ${field}`);
    const type = found[2].replace(/\s+/g, ' ');
    const kind = type.startsWith('string') ? 'string' : enums[type] ? 'enum' : 'scalar';
    if (kind === 'scalar' && !scalars[type]) throw new Error(`there is no type ${type}`);
    return {name: found[3], key: Boolean(found[1]), count: found[4] ? Number(found[4]) : 0, kind, type, names: enums[type]};
  });
}

// One sample, encapsulation header first. 64-bit integers become BigInt, enumerators their names without prefix.
export function readCdr(fields, bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const little = (view.getUint8(1) & 1) === 1;
  const start = 4;
  let at = start;
  const number = (size, get) => {
    at += (size - ((at - start) % size)) % size;
    const value = get(view, at, little);
    at += size;
    return value;
  };
  const uint32 = () => number(4, scalars['unsigned long'][1]);
  const one = field => {
    if (field.kind === 'scalar') return number(...scalars[field.type]);
    if (field.kind === 'enum') {
      const value = uint32();
      return field.names[value] ?? String(value);
    }
    const size = uint32();
    const text = utf8.decode(new Uint8Array(bytes.buffer, bytes.byteOffset + at, Math.max(size - 1, 0)));
    at += size;
    return text;
  };
  const sample = {};
  for (const field of fields) {
    sample[field.name] = field.count ? Array.from({length: field.count}, () => one(field)) : one(field);
  }
  return sample;
}

// Which instance of its topic a sample is of.
export function instanceOf(fields, sample) {
  return fields.filter(field => field.key).map(field => sample[field.name]).join('/');
}
