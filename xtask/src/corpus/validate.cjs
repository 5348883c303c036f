// Prints the errors that OUT.glb has beyond those of the model that it was baked from, if that is glTF too:
// node validate.cjs MODULE MODEL OUT.glb
const validator = require(process.argv[2]);
const { readFileSync } = require('fs');
const errors = async path => {
  const bytes = new Uint8Array(readFileSync(path));
  const { issues } = await validator.validateBytes(bytes, { maxIssues: 0 });
  return issues.messages.filter(({ severity }) => severity === 0);
};
(async () => {
  let known = [];
  try {
    known = (await errors(process.argv[3])).map(({ code }) => code);
  } catch {
    // The model is no glTF.
  }
  try {
    const found = (await errors(process.argv[4])).filter(({ code }) => !known.includes(code));
    if (found.length > 0) console.log(`validator: ${found.length} errors: ${found[0].message} ${found[0].pointer}`);
  } catch (error) {
    console.log(`validator: ${error}`);
  }
})();
