"use strict";
// The filter of the table. It means what `tribosweep query --where` means by the same words, and
// refuses the rest. Two things are added for who types here: a word is looked for in the row, and a
// text may stand without quotes.
const jobFilter = (() => {
  const TOKEN = /\s*(?:(&&|\|\||==|!=|<=|>=|[<>!()[\],])|"([^"\\]*)"|'([^'\\]*)'|([^\s&|=!<>()[\],"'\\]+))/y;
  const RELATIONS = {
    "==": order => order === 0, "!=": order => order !== 0, "<": order => order < 0,
    ">": order => order > 0, "<=": order => order <= 0, ">=": order => order >= 0,
  };
  const TURNED = { "<": ">", ">": "<", "<=": ">=", ">=": "<=" };
  const KNOWN = "This filter knows == != < <= > >= && || ! ( ) in [ ] null and words; "
    + "tribosweep query --where knows more.";
  const refuse = words => { throw new SyntaxError(words); };

  function tokens(text) {
    const found = [];
    for (TOKEN.lastIndex = 0; TOKEN.lastIndex < text.length && /\S/.test(text.slice(TOKEN.lastIndex));) {
      const from = TOKEN.lastIndex;
      const match = TOKEN.exec(text);
      if (!match) {
        const rest = text.slice(from).trim();
        const hint = { "=": "Equality is written ==.", "&": "And is written &&.", "|": "Or is written ||." };
        refuse(`${rest.slice(0, 12)} cannot be read. ${hint[rest[0]] ?? KNOWN}`);
      }
      const [, sign, double, single, word] = match;
      found.push(sign ? { sign } : word !== undefined ? { word } : { quoted: double ?? single });
    }
    return found;
  }

  // Conditions are functions of a row: true, false, or null where a missing value leaves it open.
  const not = a => row => { const x = a(row); return x === null ? null : !x; };
  const and = (a, b) => row => {
    const [x, y] = [a(row), b(row)];
    return x === false || y === false ? false : x === null || y === null ? null : true;
  };
  const or = (a, b) => not(and(not(a), not(b)));

  const kindOf = x => (typeof x === "number" ? "a number" : "text");
  const order = (a, b) => (a < b ? -1 : a > b ? 1 : 0);

  // Returns a function that is true of the rows for which a text holds. `cell` gives the value of
  // a column in a row, `holds` whether a row has a word.
  return function compile(text, columns, cell, holds) {
    const rest = tokens(text);
    const next = () => rest[0] ?? {};
    const take = sign => next().sign === sign && rest.shift();

    function operand(token) {
      if (token.quoted !== undefined) return { value: token.quoted, name: `"${token.quoted}"` };
      const column = columns.find(column => column.name === token.word);
      if (column) return { column, name: token.word };
      if (token.word === "null") return { value: null, name: "null" };
      if (/^[+-]?inf$/.test(token.word)) return { value: token.word[0] === "-" ? -Infinity : Infinity, name: token.word };
      if (/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(token.word)) return { value: Number(token.word), name: token.word };
      return { value: token.word, name: token.word, isBare: true };
    }
    const kind = ({ column, value }) => (!column ? kindOf(value) : column.kind === "mixed" ? null
      : column.kind === "number" ? "a number" : column.kind === "text" ? "text" : null);
    const at = ({ column, value }) => (column ? row => cell(row, column) : () => value);

    function compared(left, sign, right) {
      if (!left.column && !right.column) {
        const named = left.isBare ? left : right;
        refuse(`There is no column ${named.name} in this table.`);
      }
      if (!left.column) [left, right, sign] = [right, left, TURNED[sign] ?? sign];
      if (right.value === null) {
        if (sign !== "==" && sign !== "!=") refuse("null can only be compared by == and !=.");
        return row => (cell(row, left.column) === null) === (sign === "==");
      }
      const [a, b] = [kind(left), kind(right)];
      if (a && b && a !== b) {
        if (right.isBare) refuse(`There is no column ${right.name} in this table, and ${left.name} is a number.`);
        refuse(`${left.name} is ${a} and ${right.name} is ${b}; they cannot be compared.`);
      }
      const [x, y, relation] = [at(left), at(right), RELATIONS[sign]];
      return row => {
        const [p, q] = [x(row), y(row)];
        if (p === null || q === null) return null;
        if (typeof p !== typeof q) {
          refuse(`${left.name} is ${kindOf(p)} in some row and ${right.name} is ${kindOf(q)}; they cannot be compared.`);
        }
        return relation(order(p, q));
      };
    }

    function list() {
      const members = [];
      while (!take("]")) {
        const token = rest.shift() ?? {};
        if (token.sign || token.word === undefined && token.quoted === undefined) refuse(`A list ends with ]. ${KNOWN}`);
        members.push(operand(token));
        if (!take(",") && next().sign !== "]") refuse(`The members of a list are separated by commas. ${KNOWN}`);
      }
      return members;
    }

    function simple(isNegated) {
      if (take("!")) return not(simple(true));
      if (take("(")) {
        const inner = either();
        if (!take(")")) refuse("A parenthesis is not closed.");
        return inner;
      }
      const words = [];
      while (rest.length && !next().sign) words.push(rest.shift());
      const { sign } = next();
      if (isNegated && (RELATIONS[sign] || sign === "[")) refuse("What ! negates stands in parentheses: !(mu > 0.3).");
      if (!words.length) refuse(sign ? `Something is missing before ${sign}.` : "Something is missing at the end.");
      if (sign === "[" && words.length === 2 && words[1].word === "in") {
        rest.shift();
        const value = operand(words[0]);
        if (!value.column) refuse(`There is no column ${value.name} in this table.`);
        return list().map(member => compared(value, "==", member)).reduce(or, () => false);
      }
      if (RELATIONS[sign]) {
        if (words.length !== 1) refuse(`Before ${sign} stands the name of one column. ${KNOWN}`);
        rest.shift();
        const value = rest.shift() ?? {};
        if (value.sign || value.word === undefined && value.quoted === undefined) refuse(`Something is missing after ${sign}.`);
        if (rest.length && !next().sign) refuse(`Several words after ${sign} stand in quotes. ${KNOWN}`);
        if (RELATIONS[next().sign]) refuse("a < x < b is written a < x && x < b.");
        return compared(operand(words[0]), sign, operand(value));
      }
      if (sign && !/^(&&|\|\||\))$/.test(sign)) refuse(`${sign} cannot stand there. ${KNOWN}`);
      const wanted = words.map(token => token.word ?? token.quoted).join(" ").toLowerCase();
      return row => holds(row, wanted);
    }
    function both() {
      let condition = simple(false);
      while (take("&&")) condition = and(condition, simple(false));
      return condition;
    }
    function either() {
      let condition = both();
      while (take("||")) condition = or(condition, both());
      return condition;
    }

    if (!rest.length) return () => true;
    const condition = either();
    if (rest.length) refuse(`${next().sign} cannot stand there. ${KNOWN}`);
    return row => condition(row) === true;
  };
})();
