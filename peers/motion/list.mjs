#!/usr/bin/env node
// Prints the models as JSON, each with its name and its file, for programs in other languages.
import { dancer } from './character.mjs';
import { makeModel } from './made.mjs';
import { models } from './models.mjs';
import { cache, getPackages } from './packages.mjs';

// What libraries say goes to the other stream.
console.warn = console.error;
const modules = getPackages();
console.log(JSON.stringify([...models(cache), await dancer(cache, modules), { name: 'made', file: makeModel(cache) }]));
