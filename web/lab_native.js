// The program's own figures, which the page shows beside its own. `touchable-bench paper --json paper.json` gives them
// (with --quick those of 10 s): force_hash of each case, and of Table I primitives_second_max and primitives_mean.

/** Fig. 19, by the end of the cases' names: metric pixel, then world; each without a filter, -m3, -m5, -m5-t, and with
 *  -temporal (not of -still, a single frame). */
export const scratches = {
  'n1': ('6cf1bbc1d917d319 50b8200a3b12c7cd f7bbbc9de8fba090 3196adadc4c3e1f6 40db7dd957aa468f ' +
    'd111152ce24c7757 e715bd0761424f09 148e07d7514c1a44 c89b4054ed58913c fb7d9a4ff9fc89f2').split(' '),
  'n0.5': ('8a28885bde0d38dd ec1154efda93fef5 f1537b36362902b2 381a9aba631b51a0 381a9aba631b51a0 ' +
    'ba6801bec42c9384 e1a32c93e367f850 d8c2825caad1a22d 5442e40db6366c6c 5442e40db6366c6c').split(' '),
  'n2': ('4fab04c6ceaf1873 d3e356c19a55cd43 9e3832d7e94dea07 ac813b725b53c6cc 80d8ada5d5297b21 ' +
    '5f99f1ba41225607 f3e815cd496101af 0aa0d0bd78037965 516ce602786dae0c 4992967bd44f5ef8').split(' '),
  'n1-hard': ('fd4f70307ac7c07a 11fbfbe02864d788 6f2a0dec656c3edf 1119521de61bdd92 9458add5569587f9 ' +
    'fd5dcbc3e7b7bd61 b097dad7a809a560 a085bcdea1310815 9ea7978ae74fc9e1 df74306e9cd28268').split(' '),
  'n1-fast': ('e5582936824df433 e3acab133709aed5 35bbbef0a8a53131 53f87f3de34dcc5d 8f5f1523ba47c00a ' +
    '93be18e4995cbc63 8dceac67879c8f17 ca526ff9c3a92efe 9d5dfa01333ed869 3f0ef2c7c383563e').split(' '),
  'n1-firm': ('76764d63da289060 319aa8afd0e0af96 6d3fcb42d8c507ef 8660b4aea0dd8e3b b8f81c5cb56fb052 ' +
    'ee1c33becf78d39e a9ec42e6ad5c915c 7323a0a8d9e959ab d3cb8babaed773fb 347b3d88c08bb701').split(' '),
  'n1-still': ('d04fb6e057c362db e8c49e392db224ac 20b8a285d0136f29 7357f6f059ac4bee 308fb7e6e26dde8d ' +
    '7d62aa27b156ddf0 98ff176e205e5cb2 079c82eb7c6c65e7').split(' '),
  'n0.5-still': ('53e9d8ad1ef357a1 91c89b0d0b281469 3b288b97ca986dbe 41baa8dba7d2ae9c ac51b8e8a73a7029 ' +
    '13d08750c2150d4a a1aac5ef760493e4 875cf3143e6babb9').split(' '),
  'n2-still': ('bdfcd2597210a4cb 4bd947d60a7efb5e 878620a42373f6b4 f037ca80443b7f70 b505f7a864e85a46 ' +
    'e01fccce6c84a256 4a26ede76eba4224 8a440a5ddb18a5b7').split(' '),
};

/** Table I, by content, metric and seconds: largest, mean and hash of line, circle, eight. */
export const sweeps = {
  'globe pixel 10': '64.2 5.362 856d5049177ec1e2 45 6.053 e090fefdde29b19e 47.9 5.595 bda7bba767cda47d',
  'globe pixel 30': '56.4 5.294 65f2f12bb8604696 45 6.053 fbafe8cb9a18f1ab 47.13 5.589 6f4689cd17c24d9f',
  'globe world 10': '63.4 5.887 bf8360de9d8bd641 51 8.282 ae3b1d2f7f6be471 74.9 6.192 aae0ba33c242219f',
  'globe world 30': '57.7 5.739 3181d1981bc461c1 51 8.282 7212024203c8700f 64.8 6.204 4289beadc4ec7a5e',
  'chest pixel 10': '15.9 2.357 e252f08af2d72c82 17.1 2.95 3cf2d664f4921546 15.4 2.501 04242dbe2a5a9484',
  'chest pixel 30': '15 2.362 23d9f00f14ed4fd5 18.77 2.937 8b833acf9dfadf7b 17.77 2.494 6f62ea588c775e71',
  'chest world 10': '5 2.703 f6a056da813720d3 5 3.329 b91beb1b1808da7e 5 2.813 9011a297f21e71cf',
  'chest world 30': '5 2.674 d70e01a8ef2ed256 5 3.328 eb8de8e55670283c 5 2.813 4f9ab46ca2846b1b',
};
