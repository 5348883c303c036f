// Prints the errors and warnings of a .glb file, and the first message: node validate.cjs MODULE FILE
const validator = require(process.argv[2]);
const bytes = new Uint8Array(require('fs').readFileSync(process.argv[3]));
validator.validateBytes(bytes).then(({ issues: { numErrors, numWarnings, messages } }) => {
  const first = messages.find(message => message.severity <= 1);
  if (numErrors) console.log(`validator: ${numErrors} errors, ${numWarnings} warnings: ${first.message} (${first.pointer})`);
});
