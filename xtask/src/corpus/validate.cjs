// Prints the errors that OUT.glb has beyond those of the model that it was baked from, if that is glTF too:
// node validate.cjs MODULE MODEL OUT.glb
const validator = require(process.argv[2]);
const { readFileSync } = require('fs');
const judge = async path => {
  try {
    return (await validator.validateBytes(new Uint8Array(readFileSync(path)))).issues;
  } catch {
    return { numErrors: 0 };
  }
};
(async () => {
  const before = await judge(process.argv[3]);
  const { numErrors, messages } = await judge(process.argv[4]);
  const first = messages.find(({ severity }) => severity === 0);
  if (numErrors > before.numErrors) console.log(`validator: ${numErrors} errors, ${before.numErrors} before: ${first.message} ${first.pointer}`);
})();
