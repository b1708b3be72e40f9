#include "language_test.h"

/* Programs drawn at random: what they come to by Radiance's own evaluator (calexpr.c and its
 * kin built apart, with rayinit.cal). They mix what can go wrong together: arguments that are
 * asked for late, twice or never, functions handed on by name, recursion, constants. */
static const struct {
    const char *text, *expression;
    double value;
} programs[] = {
    {"f0(p0,p1,p2) = if(p0-.7,(Exp(if(p1,p1,p1))-1-2+and(0,p0))+.5*f0(p0-1,p1,p2),1.27); "
     "f1(p0,p1) = if(p1-.7,0+.5*f1(p0,p1-1),(1*p1)); f2(p0,p1,p2) = f1(frac,or(f1(sq,p1),2));",
     "if((if(A1,2,0))^2,erf(2),.5)", 0.99532226501895271},
    {"f0(p0,p1) = if(p0-.7,(grey(sq(p0),p0,mod(p1,p1))*-p0)+1*f0(p0-1,p1),T); v1 = "
     "ceil((0*AC*3)^1); v2 = (((v1-Dx)/3.62)*(-A1-sgn(1))); f3(p0) = (v1+v1);",
     "f0(v2,f3(Sqrt))", 12.5},
    {"f0(p0,p1,p2) : atan2(((p1+p0)+sq(p0)),((p1-2.14)-bound(p1,T,3))); f1(p0,p1) : (-p1*p1); "
     "v2 = f0(2.21,f0(.5,inside(Dx,A2,0),sgn),floor); v3 = "
     "if((.5-Pz-2*f1(Nz,3)),2,f0(2,(v2+2.18),Exp)); u3 = 1; v4 = v3; f5(p0,p1) : "
     "grey(if(-p0,mod(Dx,p1),(p1-p0)),sq(p1),v4*.5-p1*f0(p0,v2,sin)+(v2/p1)); v6 = "
     "f1(sq(Nz),(v2+3-T*tri(v2,v2))); c7 : .5*3; v8 = f0((frac(3)/(Dx*1)),(c7-(v6/Px)),not);",
     "select(f5(v3,atan2(.5,0)),(grey(1,1,Nz)-f1(.5,Px)),(A2+T)-0.758*1.63*.5-f0(Dx,A1,frac))",
     2.6866298153640003},
    {"f0(p0,p1) = if(p0-.7,(((A1+3)*2)+grey(0.00876,p1,and(p1,A1)))+1*f0(p0-1,p1),max(Py,2)); "
     "f1(p0,p1) = if(p1-.7,cos(noneg(f0(p1,p1)))+1*f1(p0,p1-1),(Dx*2)); c2 : 3*.5; f3(p0,p1) = "
     "if(p1-.7,(sq((p1)^3)*f0(p1,(p1+c2)))+.5*f3(p0,p1-1),p1);",
     "f3(erf,sin((AC*0.198)))", 0.38573099281469703},
    {"f0(p0,p1) : 2; c1 : 2*.5; f2(p0,p1,p2) = "
     "if(p0-.7,linterp(c1,(p0/"
     "(p0)^2),linterp(max(1,p2),if(c1,p1,p1),select(p2,p2,c1)))+1*f2(p0-1,p1,p2),if(1,c1,.5)); "
     "v3 = noise3((frac(A2)+grey(c1,c1,Nz)),(.5--.5),(sin(Pz)-(.5*1))); f4(p0,p1) : "
     "(Sqrt(-0)/f2(f2(1,Dx,2.6),inside(p0,p0,p0),(p0-p0))); v5 = ((abs(3.28)*f4(0,noneg))+AC);",
     "and((v3-erf(v3)),if(2,if(A1,Pz,v5),(Py-v5)))", -0.024144488379409246},
    {"f0(p0) : 3; f1(p0,p1,p2) : p0; f2(p0) : "
     "(noneg(2.6)+(p0+3)+(2.33+A2)/inside(3,3.77,(3+p0))); v3 = (3)^1; f4(p0,p1,p2) = "
     "if(p0-.7,Sqrt(f0(A1-p1*Py))+1*f4(p0-1,p1,p2),(1-2.2)); u4 = f2(-v3); f5(p0,p1,p2) = "
     "select((-p2+-v3),sgn(f2(p2)),(bound(p2,3,p2)*(2)^2));",
     "((f2(AC)/(.5/2.96))-f1(atan2(1.84,A1),xor(Nz,v3),f5(Nz,rand,2)))", 57.244667076425024},
    {"f0(p0,p1,p2) = "
     "if(p1-.7,select(p2*p2*p2,p1-1+Py,0)-(3-sq(p2))+if(p1,p1,p0(1))+.5*f0(p0,p1-1,p2),-p1); "
     "v1 = Py; u1 = A1-frac(0)*3; v2 = A1; f3(p0,p1,p2) = "
     "if(p1-.7,sgn(p0((p2)^1.7))+.5*f3(p0,p1-1,p2),p2);",
     "f0(floor,atan2(inside(3,.5,2),sq(1.18)),Exp(if(1,1.55,AC)))", 1.0626252547600901},
    {"f0(p0,p1,p2) = 3.74; v1 = ((3*3)-(3-A1)+f0(0,floor,3.96)*3); f2(p0,p1) = "
     "(f0(f0(v1,sgn,3.61),sin,(0-p0))+p0); v3 = f2((Sqrt(v1)+noise3(.5,v1,v1)),Exp);",
     "(((A2+v3)/3)-if(2+v1+0,and(0.692,3),min(Nz,v3)))", -0.27517533293436358},
    {"v0 = or(Dx,(1.16+0.929)+(AC-3)*(1+Px)); f1(p0) = .5; f2(p0,p1,p2) = "
     "if(p1-.7,sin(sin(noneg(p2)))+p2*f2(p0,p1-1,p2),if(p2,p1,0)); f3(p0,p1) = (-p0)^3; "
     "f4(p0,p1,p2) = (min(2.33*p0+0,mod(p2,p0)))^0; f5(p0,p1,p2) : "
     "(sin((AC+3))-f4((1/p0),(1.4)^3,p1));",
     "f3(abs(1),(3-f2(not,2.62,.5)))", -1},
    {"f0(p0,p1,p2) : if(p2,-p2,1); c1 : 2*2; v2 = (cos(c1)+(1.42)^2-max(1,0))^.5; v3 = "
     "erf((bound(0,v2,1)*(v2*Dx))); f4(p0) : "
     "and(if((v2*p0),xor(0,p0),bound(p0,p0,p0)),(f0(p0,1,c1)+inside(p0,p0,p0)));",
     "bound(f4(T),v2,(1.14+c1))", 0.60229260259145478},
    {"v0 = (0-(.5+linterp(3,A1,3))); v1 = if(abs(min(Py,Nz,Pz)),0.324,3.17); f2(p0,p1) : "
     "(((p0)^1.7*inside(AC,A1,AC))+noise3(noise3(p1,Py,T),tri(p1,p1),(p0-p0))); f3(p0,p1) = "
     "if(p1-.7,mod(p0((3/.5)),AC)+p1*f3(p0,p1-1),0); v4 = 1; f5(p0) : "
     "mod((p0-(.5+p0)),f3(atan,-p0));",
     "Exp(noise3((AC+0.729),frac(v0),-Dx))", 1.1597077885367728},
    {"v0 = (xor(3.59,grey(3.87,2,2))*.5); f1(p0,p1) = -p1; f2(p0) = f1(2,tri((v0+0.409),v0)); "
     "c3 : 1*2.23; v4 = atan(((.5/3))^0); f5(p0,p1) = if(p0-.7,-A2+p1*f5(p0-1,p1),p0); "
     "f6(p0,p1) = noise3(2,p1((p0-0)),p0); f7(p0,p1) = "
     "if(p0-.7,Exp(.5)+1*f7(p0-1,p1),.5-p1-Px); f8(p0,p1,p2) = "
     "f5(if(v0*p0-p0,p1,(.5-p0)),and(p0,Py));",
     "(f6((0+2),not)+Px)", 1.3},
    {"v0 = atan2((erf(A2)/(2.58*AC)),inside((3.24*1),0,(Dx*Dx))); f1(p0,p1) = "
     "if(p1-.7,(p0(1)-0)+p1*f1(p0,p1-1),p0(p1)); v2 = 1; v3 = 2;",
     "((v0+inside(v2,3,v3))/if((.5*3),(2)^0,(1)^.5))", 2.1159742551399208},
    {"f0(p0,p1) : 3; f1(p0,p1,p2) = f0(erf,sin); v2 = 1.39; f3(p0) : "
     "(p0-f1(Nz,p0,2))*f0(rand,sq)-(atan2(v2,Pz)/f0(frac,sgn)); v4 = "
     "ceil((if(v2,Px,v2)/(2+1))); v5 = (.5+(v4)^1.7+(Py*2)+(2+AC+v4*(.5*1))); u5 = "
     "if(inside(v2,3,1),A1,f0(floor,atan)); v6 = (Pz*(noise3(0,3,A2)+1)); v7 = f0(floor,abs); "
     "c8 : 1*0;",
     "tri(v6+grey(2,v5,Px)-2,f1((v4+.5),sin(v6),or(c8,A2)))", 0.072576374899999685},
    {"f0(p0,p1,p2) = Sqrt(noneg(p2)); f1(p0,p1,p2) : not(p2); f2(p0,p1) : "
     "erf(f1(floor(p0),A2,atan2(T,2))); v3 = -.5; f4(p0,p1,p2) = "
     "f0(sin,f2((v3*p0),atan(p1)),.5); f5(p0) : noise3(-v3,-v3,.5); f6(p0) = "
     "if(p0-.7,(((1)^.5*(.5+.5)))^0+p0*f6(p0-1),p0); f7(p0,p1,p2) : "
     "floor(f0(f6,p1,and(2,A2)));",
     "f2(if((T-3),or(Dx,.5),-.5),1)", -0.84270079294971489},
    {"f0(p0,p1) = if(p0-.7,(2+0)+1*f0(p0-1,p1),(p0-p0)); f1(p0) : .5; v2 = abs(f0((2-.5),f1)); "
     "f3(p0) : (f1(f1(p0))+(bound(p0,p0,p0))^.5);",
     "f0(f3(2),cos)", 4},
    {"v0 = 3; f1(p0) = if(p0-.7,p0+.5*f1(p0-1),p0); f2(p0,p1) = "
     "if(p0-.7,floor(and(if(p0,p1,1),min(v0,2)))+p1*f2(p0-1,p1),f1(A1)); f3(p0,p1,p2) = "
     "if(p1-.7,(cos((v0-v0))*2)+p2*f3(p0,p1-1,p2),.5*p1*p2); f4(p0,p1) : "
     "bound(p1,if(p0(0),atan2(v0,p1),(2-.5)),(max(0,Nz)*xor(A1,.5))); c5 : 0*2; u5 = "
     "(c5-erf(Nz)); f6(p0,p1) = (f2(f3(cos,p1,p1),inside(c5,2,1))-Exp(min(0.737,0,p1))); v7 = "
     "f2(-Pz,(f1(0.522)+1.44)); v8 = 3.13; u8 = Nz;",
     "noise3((.5*2)+Pz-and(1.3,v0),abs(f1(0)),f1((1.63-c5)))", 0.35754710327162287},
    {"v0 = (0+(grey(0,3,2.32)-if(Pz,AC,Pz))); u0 = A2; f1(p0,p1,p2) : .5; v2 = "
     "(inside(3,v0,Py)*or(v0,0))-AC+inside(floor(v0),if(1,1,v0),inside(AC,T,.5)); v3 = "
     "((max(0,v0)/v0)-f1(-v2,(3-.5),Pz)); u3 = f1((v3/2.96),-v2,-1.14); v4 = "
     "(v3-atan((T)^1.7)); f5(p0) = (if((1+v2),A2,f1(v4,3.73,0.158)))^.5; v6 = "
     "(v3*f5(0))*v3-((v3*Pz)+if(A2,v3,1)); u6 = atan(inside(T,v6,Nz));",
     "and(1,(erf(v3)-f1(Px,Dx,.5)))", 0.020499877813046519},
    {"f0(p0) : (p0)^2; v1 = Px; f2(p0,p1,p2) = if(p0-.7,p0+1*f2(p0-1,p1,p2),f0(p0)); "
     "f3(p0,p1,p2) = (min(sq(p0),(2.87+p2),(.5*v1))-p0); v4 = "
     "f2(2,atan2((A1-.5),3+0+1),min(mod(1,1),v1)); f5(p0,p1) : erf(xor((p0)^2,Nz)); v6 = "
     "cos(f5(tri(v4,2),Exp)); u6 = (f0(v6)/erf(v1)); v7 = (3*((0.228/T)-2.96)); u7 = "
     "inside(v1-2+A2,(2*3),(.5+1));",
     "f0((f5(AC,Exp)-grey(2,2.92,v4)))", 12.41869931542468},
    {"v0 = (((A1)^1.7*Dx))^1; f1(p0,p1) = p1*erf(inside(v0,p0,p1))-p0; v2 = "
     "linterp(frac(v0),Dx-inside(1,v0,v0)-v0,floor(and(.5,0))); f3(p0) = "
     "if(p0-.7,(p0*erf(inside(T,1,3.93)))+1*f3(p0-1),Py); v4 = v0; f5(p0,p1,p2) = "
     "if(p0-.7,(or((p1)^2,(p0+p1))*((Dx-p1)-(2.97*Pz)))+p1*f5(p0-1,p1,p2),p0); u5 = "
     "(-.5*(v4/1)); v6 = (v4-Py); f7(p0) : sgn((grey(v6,p0,v6)+(p0+p0))); v8 = 2.13;",
     "bound((3+(2-1)),(v8*if(0,Pz,v8)),((0*Nz)-f7(A1)))", -1},
    {"v0 = -3; v1 = .5; v2 = sin((2*(1-.5))); f3(p0) = "
     "if(p0-.7,and((linterp(0,Py,p0)-select(0.0381,p0,v0)),Dx)+1*f3(p0-1),0); v4 = rand(-Py);",
     "(((v1*v0)*if(T,v4,0)))^3", -0.01710846450414685},
    {"f0(p0) = if(p0-.7,linterp(((p0*p0)--0),if(Nz,(p0*Py),sq(Nz)),p0)+p0*f0(p0-1),(AC*p0)); "
     "f1(p0,p1,p2) = ((-p1+0)*f0(p1)); v2 = -2; v3 = ((f0(A1)+1)-((v2+Py)+3)); v4 = "
     "grey(-0,f1(f0(2),(3+2),-v3),and(if(1,0.511,.5),A2+v3*v2)); f5(p0,p1) = "
     "if(p0-.7,f1(-2.41,p0,f1(f1(v4,p0,p0),v4,-p0))+p1*f5(p0-1,p1),if(p0,1,p1));",
     "grey(f0(1),.5+linterp(0,v4,Px)*(0)^3,2)", 0.72975392750000012},
    {"v0 = 1; v1 = Sqrt((.5-A2)); v2 = ((Sqrt(1)+(2*Nz))-0.103); c3 : 2*3.16; f4(p0) = 3.5; "
     "f5(p0,p1) = c3+ceil(if(p0,A1,p0))*c3;",
     "min((f4(Py)*v2),min((1.55*v1),atan2(Py,3)),f5(f4(1.41),f4))", -0.67474094222355263},
    {"f0(p0,p1) : p0; v1 = if(3.69*(1+1.11)+-.5,erf(Sqrt(3)),f0(3,frac)+(0-Nz)*f0(3,not)); "
     "f2(p0,p1,p2) : (grey((v1-.5),p2(p1),p1)/bound(p0(Dx),if(p1,A2,p1),p2(p1))); v3 = Pz;",
     "f2(sgn,tri(f0(v3,sin),linterp(v3,.5,v3)),abs)", 0.55500195169706623},
    {"f0(p0) = mod((1.63/inside(2,3,p0)),.5); f1(p0) : 3.18; v2 = f1(ceil); f3(p0,p1,p2) = "
     "if(p0-.7,cos(-p1-or(v2,v2)*not(p0))+1*f3(p0-1,p1,p2),not(p0)); u3 = "
     "f3((Dx-v2),xor(v2,A1),bound(Pz,T,v2)); f4(p0,p1,p2) = "
     "if(p0-.7,(f1(sq)-mod((Px+p2),if(0.639,v2,p1)))+p2*f4(p0-1,p1,p2),min(v2,1,p0)); v5 = "
     "-Py; v6 = (.5-.5); f7(p0,p1,p2) = if((noneg(2))^1.7,f3(if(v6,p0,p0),.5,.5),p0);",
     "f0(sq(or(0,0)))", 0.45666666666666667},
    {"f0(p0) = if(p0-.7,2+.5*f0(p0-1),(0-1)); f1(p0) = "
     "if(p0-.7,f0(if((p0+p0),f0(p0),f0(Nz)))+.5*f1(p0-1),(0.245+p0)); f2(p0,p1) : "
     "(0.158+(p1*2)); f3(p0,p1) = "
     "if(p0-.7,f1(if(f2(rand,p0),min(p0,p1),3))+1*f3(p0-1,p1),f0(p0)); f4(p0,p1,p2) = "
     "f1(f2(atan,f1(p0))); v5 = (min((.5*3),2-.5*A2)-.5); f6(p0) = "
     "or(grey(-p0,v5-p0-p0,(p0-p0)),-p0); u6 = inside(min(v5,Pz,v5),(Pz-.5),(0.187+T));",
     "(or(0,f0(0))*sgn(1))", -1},
    {"v0 = floor(A1); v1 = 1*(1)^0-(Px+tri(.5,1)); v2 = A1; u2 = (3-2)-if(v0,3,Pz)+v2; "
     "f3(p0,p1) = if(p0-.7,3+p1*f3(p0-1,p1),(p0)^1.7); v4 = (2)^0; v5 = "
     "min(f3(floor(0.194),-1),-AC,frac((v1*v1))); u5 = noise3((v1-A1),f3(v2,1),(0-2)); v6 = "
     "(((1+.5)-mod(T,v0))/2.86);",
     "mod(3.8,f3(1,(1+Px)))", 0.79999999999999982},
    {"f0(p0) = if(p0-.7,((select(1,p0,p0)*-p0)*p0)+.5*f0(p0-1),p0); v1 = "
     "(if(.5,A2*AC-3,select(1,2,2))+f0((3*.5))); f2(p0,p1) : (frac((p1-1))-p1); c3 : 0*1; "
     "f4(p0) : (grey(Exp(p0),v1,p0)/min(Py,Dx,v1)+(1.2+2)+f2(Exp,p0)); v5 = "
     "atan2(1,(0.465/Dx+Px-3));",
     "(if(Px,3.72,0.593)+xor(.5,Nz)+atan2(.5,Px)-(Nz-v5))", 4.0976397389871142},
    {"f0(p0) : abs((1+(p0)^1.7)); v1 = "
     "(((Px*2)/inside(Dx,3.81,A2))*min((.5-A2),min(0.866,0,Px))); f2(p0,p1) = "
     "if(p0-.7,p0+p1*f2(p0-1,p1),(A2/v1)); v3 = f0(f2(bound(v1,1,Py),3.82)); f4(p0,p1) = "
     "sq(p1);",
     "rand((f0(1)*.5))", 0.35008305980591103},
    {"v0 = if(1,atan2((Pz-AC),(Dx+Dx)),atan2(3,min(3,0,0))); f1(p0,p1,p2) : p1; c2 : 1.53*0; "
     "v3 = Px; v4 = f1(inside((2/Pz),Nz-v3+v0,A2),.5,(if(Dx,Dx,v3)+tri(A1,1))); v5 = "
     "(select(f1(c2,.5,A2),grey(0,AC,A2),(v0+3))+mod(sq(A1),f1(Px,1,1))); v6 = "
     "Sqrt((0-abs(2))); f7(p0) = Sqrt(f1(f1(AC,p0,p0),f1(p0,v0,p0),atan(3)));",
     "(v6+if(2,2.88,(v4-2)))", 2.8799999999999999},
    {"v0 = bound(erf((1+0)),xor(3,(.5+Dx)),((1.96+3)-0)); v1 = v0; f2(p0,p1,p2) = "
     "select(p1,linterp(noise3(2.18,p1,T),1.52,(p2+A1)),-p1); c3 : 1*0; u3 = Py; v4 = "
     "inside(linterp(noise3(1.79,v1,v1),bound(Dx,A1,1),max(v1,1)),(f2(sin,v1,v1)*c3*c3*1),f2("
     "rand,c3,2.67)-inside(1,.5,2)-f2(sin,Pz,Px)); v5 = (v0*noneg(0.546)); v6 = "
     "((max(3,3)/atan2(v5,v1))+2); v7 = ((noise3(v0,AC,v1)+(v0+T))+v0);",
     "inside(((T-0)+.5),f2(rand,sgn(.5),abs(T)),(v5+Pz-v6*-.5))", -7.5586258917785596},
    {"v0 = (linterp((3-AC),3,2)-sgn(1)); c1 : 2.14*0; v2 = 3; f3(p0) : (0/(-p0)^0); f4(p0,p1) "
     "= if(p0-.7,min((-p0/if(p0,AC,T)),(and(3,0)*(p0*p1)),2.68)+1*f4(p0-1,p1),(c1*A2));",
     "((.5*(v2*v2))-min((Py/.5),mod(v2,A2),f3(v0)))", 9.3000000000000007},
    {"f0(p0) = if(p0-.7,(and((p0+p0),(T*p0))*(p0*(Px*AC)))+1*f0(p0-1),p0); f1(p0,p1) = "
     "bound((p1-f0(p1)),f0(p1),(tri(p1,Py)+p1)); v2 = (sgn(2)/(select(2,3,3)-3.21));",
     "f0(f0(ceil(.5)))", 389220.5},
    {"f0(p0,p1) = 1; f1(p0,p1) = (bound(p1,(p1/p1),0.216)*A2); f2(p0,p1,p2) : "
     "(if(3,(3.71/p1),p1)/inside(f1(abs,p0),noneg(p1),p0)); v3 = "
     "f0(f1(noneg,-Pz),sgn((.5+T))); v4 = "
     "and(f0(inside(v3,.5,1),3+2-0),((Pz+2)*select(A2,Pz,v3))); u4 = .5; v5 = "
     "and(f0(ceil(A1),(.5)^2),((Dx/2)+xor(Pz,2))); v6 = Py;",
     "f1(cos,if((3+2),abs(v3),(0-1)))", 0.086400000000000005},
    {"c0 : 0*1; v1 = 0; u1 = -3; f2(p0,p1,p2) = noneg(1); v3 = f2(0,Py,3); v4 = "
     "(f2((Dx)^0,Py,(T*v3))+(Sqrt(v1)*select(v1,Dx,.5))); f5(p0) = if(p0-.7,p0+1*f5(p0-1),p0);",
     "select(Pz,-A1+Px-f5(0),inside(f5(1),f5(Nz),Nz))", -0.19999999999999996},
    {"f0(p0) : ((.5/3)-min(2,2,0)); v1 = "
     "if((.5/Pz),max(1.76,2),(2+1.86))+Pz-((1.13+3)/f0(erf)); f2(p0) : f0(atan); u2 = (Px+A2); "
     "f3(p0,p1,p2) : max(noise3(linterp(A1,p1,p0),inside(p1,2,p1),p0),Pz); v4 = "
     "(f2(ceil)*select(Py,3.66,2)-cos(A2)-grey(Px,A2,0)); u4 = ((A2+A1))^3; f5(p0) = f2(cos); "
     "f6(p0) = not((noneg(2))^2);",
     "v1-f5((0-v4))*f0(sq)", -22.10777777777778},
    {"v0 = Exp(3-select(2,Nz,A1)-min(Px,T,3.42)); f1(p0,p1,p2) : .5; f2(p0,p1) = "
     "if(p0-.7,or(-p0,f1(p1,atan,bound(p1,v0,p1)))+.5*f2(p0-1,p1),f1(p0,rand,v0)); v3 = "
     "((A1*v0)+(A2+0)-v0-if(Nz,v0,v0)*f2(0,3)*(1)^3);",
     "(f2((v0+3),(v0*Pz))-or(f2(2.98,Nz),3))", 0.03125},
    {"f0(p0,p1,p2) = AC; v1 = linterp(Dx,.5,2); f2(p0,p1) = "
     "(rand(f0(1,p0,cos))/(max(v1,2)+mod(0,Pz))); v3 = 3; f4(p0,p1) = p1; f5(p0,p1) = p1; "
     "f6(p0,p1,p2) : (select(noise3(p2,p2,2.05),-A2,(p2*p2))*Sqrt(if(p2,.5,1))); u6 = 3; "
     "f7(p0) : .5; f8(p0,p1,p2) : f4(p0(p2),f6(sin,sgn,or(3,1.7)));",
     "erf(Px)", 0.93400794494065242},
    {"f0(p0,p1) = atan(max(cos(p0),2)); v1 = bound(2,min((2*1),(1+Px)),(0+AC)*Px*atan(.5)); u1 "
     "= f0(frac(0),sgn); v2 = v1; f3(p0,p1,p2) : ((1/(A2*1))*(if(p2,Nz,p2)*(p1-p2))); v4 = "
     "inside(atan2(erf(1),f0(Pz,abs)),f3(atan,f3(Exp,AC,2),0),atan2((2-3),f3(sgn,2,Px)));",
     "(f3(Exp,(v2/Nz),sin(Px))+rand(0))", 1.6845500755628569},
    {"v0 = A2; f1(p0,p1) = AC; v2 = f1(f1(atan2(1.36,.5),floor),not); u2 = (f1(3,erf)+(0-0)); "
     "f3(p0,p1,p2) = f1(Exp(f1(p0,cos)),cos); v4 = v2; f5(p0,p1) = -p0;",
     "rand(xor(.5,.5))-if(max(0,3),ceil(v2),(3.51+1))*((1.75-A2)-(Nz/1))",
     -0.33208146478491862},
    {"f0(p0,p1,p2) = if(p0-.7,1+1*f0(p0-1,p1,p2),p1(A2)); f1(p0,p1) = cos(sq(f0(0,sq,2))); v2 "
     "= f1(not,abs); v3 = f0(f1(not,cos),sq,bound(0-3-0,grey(0,v2,.5),f0(T,noneg,AC))); "
     "f4(p0,p1) = if(p0,(min(p0,2)*if(p0,2,3)),v3*p1-v3+A2*p0+v2+bound(v3,p1,3));",
     "(((1-v2)+(A2*3))+frac(xor(Nz,A2)))", 1.2003276621046939},
    {"f0(p0,p1) = if(p0-.7,(tri(p0,and(p0,A1))+Py)+p1*f0(p0-1,p1),(2*3.3)); v1 = Py; v2 = "
     "(f0(3.19,2)*v1)*(atan2(v1,0)-f0(1,v1))-f0(rand(v1),min(1,Dx)); v3 = "
     "(f0((v2+T),(AC*v2))+if((2)^2,noise3(AC,1,1.6),v1*Px*v1)); f4(p0,p1,p2) : (Pz)^0; u4 = "
     "-A2; f5(p0,p1,p2) : 2; u5 = -0; v6 = erf(0); f7(p0,p1) = "
     "(f5(1,Dx,0)+Pz+0+.5)*and(v6,1.49)*(Dx+3)+(v6+T)-f4(Exp(0),-AC,min(0,1)); f8(p0,p1) : "
     "(and(-v3,0)*p0);",
     "f0(.5,(if(3,3,v6)-mod(2,Dx)))", 6.5999999999999996},
    {"f0(p0,p1,p2) = linterp(sq(1),(p0+0),(0-1+A2*A2)); v1 = Dx; f2(p0) = 1; f3(p0,p1) = "
     "if(p0-.7,-p1+p1*f3(p0-1,p1),bound(2,2,p0)); v4 = v1; v5 = "
     "f0(floor(A1),f0((v1*v4),3,frac),noneg); u5 = 3;",
     "(f3((AC*v5),(2+Pz))*(f0(1,3,not)-cos(0)))", 3.0911999999999997},
    {"c0 : 2*1; v1 = if((.5/2.7),0,c0)*c0+Pz; u1 = (max(v1,2)*if(c0,0,3)); v2 = .5; v3 = .5; "
     "f4(p0) = if(p0-.7,1+p0*f4(p0-1),(.5*p0));",
     "f4((0.0922+0))+Pz-f4(Py)*3-T-AC+atan(0.948)", -9.3951895440097282},
    {"v0 = ceil(3); u0 = (3-v0); f1(p0,p1) = ((abs(1)+Sqrt(v0))-erf(mod(p1,2))); f2(p0,p1) = "
     "if(p0-.7,if(((2/1)+p1),p0,frac(p1))+p1*f2(p0-1,p1),if(Px,p1,Nz)); v3 = ((Dx-(3-v0)))^1; "
     "c4 : 0*2.59;",
     "(erf((c4-2))-bound(-0.824,erf(v0),(0.278*2.25)))", -1.6208222650189528},
    {"f0(p0,p1) = .5; f1(p0,p1) : frac(f0(sq,inside(2,Py,2.86))); f2(p0,p1) = "
     "if(p1-.7,if(((p1)^0/"
     "p1),(0-p1)*(p1*p1)-(p1+AC),(and(0,p1)*(p1+p1)))+1*f2(p0,p1-1),min(p1,AC,p1)); "
     "f3(p0,p1,p2) = f2(erf,Dx); f4(p0,p1) : (inside((1*p0),f0(sin,0),-p0)-(Px*0*p1*(0+p1))); "
     "f5(p0,p1) = ((p1-if(p1,p0,.5))-(Pz*3)*(p1/1)*noneg(p0)); v6 = -.5; f7(p0,p1,p2) = "
     "((p2/Px)-v6); u7 = ((Dx*Py)*0); c8 : 3*1;",
     "if(f0(floor,tri(.5,.5)),f5(if(v6,2.06,A2),sin(T)),c8)", -0.51061150357619212},
    {"v0 = not(1); v1 = 0*(1+(T/Px))*-Nz; f2(p0,p1,p2) = ((p0/if(p0,v0,p1))*Dx); v3 = "
     "f2(min(v1,f2(2,T,noneg)),f2(v1,AC,rand)*Nz-v0-3+f2(v0,AC,not),abs); v4 = xor(v1,A2); v5 "
     "= Py;",
     "select(.5,(select(v3,Pz,v5)-cos(2)),(f2(Py,v4,Sqrt)+v4))", 2.4161468365471426},
    {"v0 = .5; f1(p0) = if(p0-.7,p0+.5*f1(p0-1),p0); f2(p0,p1,p2) = ((-p2)^0*0.779); f3(p0) = "
     "((f1(3.69)+2)+.5); v4 = if((.5*f1(Px)),0,f2(if(3.05,v0,A1),(v0/1),2.5)); f5(p0) : p0; "
     "f6(p0,p1) : -p0; v7 = (cos((1+1))+AC); u7 = (f1(Px)*0.921);",
     "erf(f6((v4+1),f2(v7,Pz,2)))", -0.84270079294971489},
    {"f0(p0) : (if(noise3(p0,p0,p0),linterp(p0,p0,3),(A1-0))+(linterp(.5,Py,3)/.5)); v1 = .5; "
     "f2(p0,p1) = "
     "if(p0-.7,atan2((f0(v1)+(p1/"
     "A1)),if(if(p1,2.49,p0),noise3(Nz,A2,T),f0(p1)))+p1*f2(p0-1,p1),f0(p1)); c3 : 3*.5; "
     "f4(p0) = A2;",
     "f4(erf)", 0.40000000000000002},
    {"f0(p0,p1,p2) = min(p0,1); f1(p0) = "
     "f0(frac(f0(.5,AC,p0)),(1-p0-p0*p0),(p0*f0(p0,.5,Px))); f2(p0,p1,p2) = "
     "(Dx+floor(1.53)+f0(p0,3,p0)-(p0+p2)); f3(p0,p1) = "
     "linterp(xor(p0,min(p0,2)),((0+p0)-f2(p0,.5,A2)),(p1(3.73)/(2-3.76))); c4 : 0*3; u4 = 0; "
     "v5 = cos(1); f6(p0,p1,p2) = ((p0*1)-(p2(p0)/(p0*p0))); f7(p0) = "
     "(((T*1)*0)*min(f1(p0),(Px-p0),c4));",
     "f3(select(min(c4,c4,v5),noise3(c4,v5,A1),(A2*v5)),sq)", 11.985056818181819},
    {"v0 = AC; v1 = (.5*3); f2(p0,p1,p2) = "
     "if(p1-.7,(Exp((v1)^2)+if(or(p1,3),p1,(p2-Px)))+.5*f2(p0,p1-1,p2),(Pz*p1)); f3(p0,p1,p2) "
     ": (atan(p2)*p2);",
     "(min(frac(.5),-.5)-xor(2,0)*v0*0*3*2)", -0.5},
    {"f0(p0,p1,p2) = 1; f1(p0) : and(((1.55*.5)*(Pz+3)),(2*and(2,0.452))); f2(p0) = "
     "(and(Dx,.5)+f0(Dx,.5,.5)-(0*.5)-3+3*tri(.5,.5)); v3 = "
     "(((1/1)+(Pz+.5))-frac(atan2(0.861,1))); u3 = linterp(f0(v3,Dx,v3),sq(3),v3); f4(p0) : "
     "f0((Py)^3,cos((T+0)),if(p0*p0*v3,p0,Sqrt(p0))); f5(p0,p1,p2) = "
     "(v3+((T)^1.7*f0(p2,v3,p1))); f6(p0,p1) = if(p0-.7,f4(p0)+.5*f6(p0-1,p1),(0.0622+v3));",
     "erf(3)", 0.99997790950300136},
    {"f0(p0,p1) = if(p0-.7,(((p1)^3-0))^1+.5*f0(p0-1,p1),3); f1(p0,p1,p2) : "
     "sgn(f0(and(p0,0),frac(p0))); v2 = ((f0(1,0)*f1(.5,sgn,3))-0); f3(p0,p1,p2) = p2;",
     "sq(Exp(T)-f1(.5,not,2)-v2)", 72003557657.203278},
    {"f0(p0) = Dx; f1(p0,p1,p2) = if(p0-.7,2.7+p0*f1(p0-1,p1,p2),f0(p0)); f2(p0) : "
     "f1((3+3)+f1(.5,sin,atan)*f0(p0),abs,Exp); f3(p0,p1) : (f1(or(1.03,p0),cos,f0)+-.5); v4 = "
     "Px; v5 = f0((3.88*tri(v4,v4)));",
     "(((v5+3.04)-f0(2))+sgn(v4))", 4.04},
    {"v0 = ((-1*3)*2.22); f1(p0,p1) : 0; f2(p0,p1,p2) : 0; v3 = v0; v4 = "
     "or(if((0)^2,(v0*1),3),(-Py*2)); v5 = "
     "(((v0+3)+noise3(v3,A2,1.45))+(if(Nz,A2,0)*grey(3,.5,v0))); f6(p0,p1) = "
     "if(p0-.7,(f2(cos,(p0-p1),cos)+and(linterp(v5,2.77,A1),f1(1,ceil)))+p1*f6(p0-1,p1),p1); "
     "v7 = ((-Px*noneg(0))*inside(-0,.5+v0-2,Py)); v8 = "
     "f2(sgn,linterp((AC+1),(1.72+v3),f1(A2,sgn)),rand);",
     "rand(v5)-v8-frac(min(Dx,A2))", -0.074147945458535092},
    {"v0 = grey(((3)^1+0.956),0,(and(Dx,3)-0)); v1 = 0.665; f2(p0,p1,p2) = "
     "if(p2-.7,(grey(v1,(v1+A2),v1)-if(p2,.5,ceil(3)))+1*f2(p0,p1,p2-1),0); v3 = "
     "f2(Exp,rand,2); v4 = v0;",
     "(f2(ceil,frac,f2(floor,ceil,Py))+bound(f2(frac,sq,A1),f2(Exp,not,0.0413),v4))",
     0.43304585240000004},
    {"f0(p0,p1) : (linterp(.5,sq(p0),if(p1,.5,0))*((p0/1)+(p1+p1))); f1(p0,p1,p2) = "
     "if(p0-.7,if(p0,p0,p1(sq(0.55)))+1*f1(p0-1,p1,p2),grey(p0,3,Px)); f2(p0,p1,p2) = "
     "min(((p0/2)/f0(.5,3.24)),min((p0-p1),sgn(2))); v3 = "
     "((-3/linterp(Nz,1,0.771))/or(abs(2.74),erf(1.23))); v4 = f0(Px,(grey(AC,2,Px)*(3+3)));",
     "(if((2*Nz),(2+3),linterp(0,v3,.5))+((v3*Dx)+(.5-v4)))", -22.110823277555159},
    {"f0(p0,p1) : floor(.5*p0-A1+p0+min(3,p0,1.64)); f1(p0,p1,p2) = (0-(-p2+select(p2,2,2))); "
     "f2(p0) = atan(p0); c3 : 0.173*2; v4 = ((2*(2)^1.7)*mod(f2(.5),(c3*3))); f5(p0,p1) : "
     "0.324;",
     "((if(Pz,.5,Nz)/3+.5+Nz)/(f0(v4,sgn)-frac(1)))", 0.40366666666666662},
    {"f0(p0) = if(p0-.7,noneg(((p0)^2-p0))+1*f0(p0-1),2); f1(p0) : p0; f2(p0) : "
     "f1(noneg(mod(Px,AC))); f3(p0,p1) = "
     "if(p0-.7,if(grey((p1*p1),(T*p1),(p1*2)),-p1,if(max(Pz,p0),Px+p0+p1,(3*p1)))+.5*f3(p0-1,"
     "p1),AC+p1*0);",
     "(Py*f3(0,1))", -4.7999999999999998},
    {"v0 = Px; f1(p0,p1) : p0; v2 = ((f1(2,v0)/abs(v0))+v0); v3 = -v0; v4 = "
     "(tri((Px+2),-.5)+if((3-1),min(1.96,v2),(0+0))); f5(p0,p1,p2) = "
     "(f1(p0+p0*p0,p0)/f1((p0*Px),-v4)); u5 = ((1.6*v2)*min(3,2)); v6 = f1((Dx/v3*3+Px),-2); "
     "f7(p0,p1) = if(p0-.7,f5(((A1*2)-p1(p0)),noneg,sgn)+1*f7(p0-1,p1),p1(p0)); u7 = "
     "((.5/2)-(v3+v2));",
     "f5(v3,sq,sq)*inside(bound(A1,3,v2),inside(2.83,A2,.5),(3-Pz))-f7(bound(2,Py,v3),sgn)",
     -3.3995857988165676},
    {"v0 = 2; f1(p0,p1) : ((p1)^1.7*p0*2.37--1); f2(p0,p1) = p1; v3 = "
     "((0+Px*Nz/bound(3.76,Nz,Pz))*2.79); v4 = f1(f2(-Dx,v0),atan2(1.01,AC)); c5 : .5*2.1; "
     "f6(p0,p1,p2) = (ceil((v3+Py))+select(p2-p0-p0,(p0)^1.7,2));",
     "f6(cos(A1),floor,erf(atan2(T,.5)))", -0.98892352968189867},
    {"v0 = atan((atan2(Dx,0)+Px)); v1 = sin(A1); f2(p0,p1) = "
     "select(erf(p0*1.35*p1),p0,not(p0)-inside(p1,p1,v0)-2.26); u2 = v0; v3 = "
     "if((f2(v0,3)+f2(Nz,v1)),v1,and(Nz,A2)*(AC*0)-(2-v1)); f4(p0,p1) = "
     "((grey(p0,0,1)+max(p0,p0))+(f2(AC,p0)+(2*0))); f5(p0) : p0; f6(p0,p1) = "
     "if(p0-.7,f5(bound(A1,p0,tri(.5,p1)))+1*f6(p0-1,p1),p0);",
     "(linterp(f6(v3,v0),(v0/Pz),frac(Nz))+sin((Pz-Pz)))", 0.54147182090032198},
    {"v0 = ((bound(2.08,Py,1))^0+0); v1 = (or(not(v0),.5+v0-3)/erf(AC)); f2(p0,p1) : p0; v3 = "
     "f2(v0,0); f4(p0,p1) : f2(rand(linterp(.5,.5,v0)),grey(1,p1,p1)-if(p1,p1,p1)+p1); v5 = "
     "(xor(0,select(2,3,0.0915))-(2+Px)+(.5/v3)+ceil(0.464)); u5 = (select(Py,1,2)+-0); f6(p0) "
     "= if(p0-.7,p0+.5*f6(p0-1),abs(p0)); v7 = 1; v8 = (if((0+3),v5,(0.31/v3))+(f2(AC,0))^2);",
     "or(if(f6(v1),grey(v5,v3,3),f2(3.16,1)),v5)", 0.411669215729},
    {"v0 = (abs((A2+1)))^1; f1(p0,p1,p2) : Exp(0); f2(p0) : "
     "p0(p0(Pz))-bound((A2+.5),(3*T),-0.972)*noise3(v0,v0,A1)+(v0/Pz)-f1(abs,v0,not); v3 = "
     "inside((erf(v0)*sgn(3.52)),Dx,1-(AC-Nz)-(1)^2); v4 = "
     "((noneg(2)+min(3,2))+(if(.5,3,v3)*(3-v3))); v5 = (sgn(atan(T))-f1(floor,(v0+v4),atan)); "
     "f6(p0) = if(p0-.7,((atan2(3,Nz)+noise3(AC,p0,3))+-p0)+p0*f6(p0-1),p0);",
     "(linterp((1+v4),2,f6(v5))+(0+v4)*min(.5,Py,v0)-v3)", -64.425878461104318},
    {"f0(p0) : .5; f1(p0,p1,p2) = noise3(Pz,f0(sq),(select(1,2,1)*noise3(2,Nz,3))); f2(p0) : "
     "cos((p0-p0+T-(3/p0))); f3(p0,p1,p2) = AC; v4 = "
     "bound(rand(Py),select(sin(2),3,(.5+.5)),f0(Sqrt));",
     "f1(Sqrt,atan,f2)", -0.38774958590028719},
    {"v0 = tri(((T*.5)-1),3); u0 = (.5-(Pz*2)); f1(p0) = "
     "if(p0-.7,if(1,tri(p0,p0)*(p0+p0)+p0,2)+p0*f1(p0-1),sin(.5)); v2 = f1(f1((AC+A2))); "
     "f3(p0,p1) : not(cos(Sqrt(p0)));",
     "((f1(A2)-(Px-.5))+sin(v2))", -0.87264656002834229},
    {"v0 = (0.44/((2.75*1)+(Pz)^1)); f1(p0,p1) = (p0/Py); f2(p0) = "
     "if(p0-.7,f1((Px-(v0-p0)),f1(f1(T,p0),floor(T)))+p0*f2(p0-1),inside(Py,A2,p0)); "
     "f3(p0,p1,p2) : (frac(p0)+(sgn(v0))^3); f4(p0) : (((2*p0)-p0)+(sin(1)+v0)); u4 = "
     "abs(0.834); f5(p0) = (p0*p0); f6(p0,p1) : max(v0,f5(sin(Px))); v7 = "
     "(v0/.5)*not(3.88)+noise3(v0,.5,Nz)*(.5-v0*0*AC)+0;",
     "(0+grey(not(1),sq(1),f2(v0)))", 0.38738178951594204},
    {"v0 = 0; f1(p0) : inside((p0/if(p0,p0,T)),noise3((3+p0),min(p0,p0),grey(p0,p0,p0)),-.5); "
     "f2(p0) = ceil(p0); v3 = ((f2(2.54)-(v0-2))*if((.5*.5),if(T,T,1),or(A2,0))); f4(p0,p1,p2) "
     ": p0; v5 = -v0;",
     "min(bound(f1(.5),(Px-2),(v5-.5)),min(if(v0,.5,v3),mod(v0,T),.5))", -0.69999999999999996},
    {"v0 = and(if(0,3,Dx)-.5-1,2); u0 = bound(2.24,Px-v0+2,cos(1)); v1 = -A2; f2(p0) = "
     "((.5+0)/1-min(0,Dx,1.98)+1); v3 = (atan2((.5-2),and(v1,.5))-3); f4(p0) = "
     "(f2(noneg)+f2(frac)); u4 = if(frac(0.94),.5,if(v0,.5,3.36)); f5(p0) = "
     "and((if(p0,3,p0)-p0*.5*Nz),p0); v6 = f5((sgn(v3)*Exp(v1))); u6 = 0; v7 = "
     "(noise3(2,2.76,1)+3.6*3.97)^0;",
     "linterp(f4(mod(1.35,1)),(select(2,2,0))^1,inside((0+3),(v3/3),abs(3)))",
     -13.831398718542236},
    {"f0(p0,p1) : (cos((T*p1))*noise3(sin(p1),or(A2,3),p1)); f1(p0,p1) = "
     "if(p1-.7,p0(p1)+p1*f1(p0,p1-1),f0(p1,1.81)); f2(p0,p1) = "
     "if(p0-.7,floor((select(p0,p0,p0)+p0*p0*2))+p0*f2(p0-1,p1),f1(floor,p0)); v3 = "
     "(Px*(0*3+1.71+min(.5,0,Nz))); v4 = "
     "if(((Pz/.5)-(v3)^0),min(T,if(Nz,2,Pz),Dx),f2(f1(Exp,1),cos));",
     "(((Px/2)+v3-0.108*Py)-f2(f1(atan,0.712),Exp))", 1.9587862630016089},
    {"f0(p0) = ((2.72*1.24)+or(p0,p0)-2.74*((1)^0)^0); f1(p0,p1,p2) = "
     "if(p0-.7,f0(atan(1))+1*f1(p0-1,p1,p2),(p2*p1)); f2(p0) = (grey(not(p0),p0,(1*p0))-T);",
     "f0(and(f1(3,0,1),1.57))", 2.2027999999999999},
    {"v0 = 3; f1(p0) = ((min(3,v0,v0)*(2*1.65))-1); f2(p0,p1) : "
     "bound(Exp(p0),or((0+A1),or(v0,p0)),min(f1(erf),or(.5,p0),f1(rand)));",
     "(1+if(f1(Exp),-v0,(Nz*v0)))", -2},
    {"v0 = (0-grey(inside(2,2,A2),A1,2)); v1 = .5; v2 = 1.53-(0*frac(1.44))-2; f3(p0,p1,p2) = "
     "if(p0-.7,.5+1*f3(p0-1,p1,p2),abs(v1)); f4(p0,p1,p2) = "
     "linterp((if(p1,1,p1)*select(p1,Px,v0)),or(min(2,Pz,v0),mod(Nz,v1)),((p1/p1))^1.7);",
     "noise3(atan2(0.425,and(v2,2.5)),f4(noneg,f4(ceil,v2,cos),frac),atan2(3*Pz+Px,(v2*A1)))",
     0.39584992295998367},
    {"f0(p0,p1,p2) : -p2; v1 = AC; f2(p0,p1) = "
     "if(p0-.7,min(A1,(f0(p1,sgn,1.49)+p1),if(p0,f0(p1,not,v1),f0(p1,sgn,p0)))+.5*f2(p0-1,p1),("
     "p0*1.5)); c3 : 3.57*.5;",
     "(if(v1,(T*Px),(c3+1))*c3)", 29.006249999999998},
    {"f0(p0) = 2; f1(p0,p1) = "
     "if(p0-.7,(if(if(p1,p1,.5),inside(3,.5,.5),inside(0,p1,p1))-p1)+1*f1(p0-1,p1),3.67); "
     "f2(p0,p1) : ((p1-p1-2.59-A2)-(rand(p1)*(p1*p1))); v3 = Pz; v4 = 0; f5(p0) = "
     "if(p0-.7,-AC+1*f5(p0-1),p0); f6(p0,p1) = if(p0-.7,0+.5*f6(p0-1,p1),(.5)^2); f7(p0,p1,p2) "
     "= AC; v8 = f1(((2.6*.5)-(3/.5)),select((2)^.5,if(3,.5,v3),.5));",
     "(v3-select(1,3,0))*f5(Exp(Dx))-f2(atan,v3)+v3*(1.2*.5)", 7.1239571762607561},
    {"f0(p0,p1,p2) : (Exp(if(p1,Py,1.34))+-p1); v1 = f0(Sqrt,not(atan(2)),abs); f2(p0,p1) : "
     "v1; v3 = sin(sin(f2(erf,AC))); v4 = (noise3(1,tri(v1,3),(3-3.05))*0);",
     "f0(noneg,f0(frac,if(AC,2,2),rand),cos)", 5.7283255520769236},
    {"v0 = (0+2.63); c1 : 0.273*.5; f2(p0) : c1; v3 = (if((v0*3),3,Pz)-Py); f4(p0,p1) = "
     "(c1+(Nz/.5)*3+-c1); u4 = Sqrt(v3); v5 = (f2(f2(T))-min(erf(Dx),Sqrt(1))); v6 = AC;",
     "f2(f2(max(2,v0)))", 0.13650000000000001},
    {"f0(p0,p1,p2) = if(p0-.7,xor(.5,0)+.5*f0(p0-1,p1,p2),-3); v1 = "
     "f0((if(A2,0.871,A2)*max(2,Py)),cos(sgn(2)),0.967); u1 = ((A1-AC)*sgn(1));",
     "not(((.5+0)*if(v1,v1,Nz)))", -1},
    {"f0(p0,p1) : (-p0+p0*floor(2)+p0); v1 = f0((-.5+(AC)^2),sin); v2 = "
     "frac(if(abs(.5),T,f0(AC,not))); f3(p0,p1,p2) = if(p0-.7,T+1*f3(p0-1,p1,p2),-p1);",
     "(0/(A1-.5))-f0((3+3),ceil)-((1/A1)/Sqrt(2))", -12.471404520791031},
    {"f0(p0,p1) = if(p1-.7,0+1*f0(p0,p1-1),min(p1,p1)); v1 = "
     "or(((.5*2)+(1/1)),(max(0,2)-(3-0.799))); u1 = f0(floor,(0+v1)); c2 : 1*2.52; "
     "f3(p0,p1,p2) = (bound(min(p0,Pz),0-p0*p1,.5)*((p0-v1)/f0(atan,c2))); f4(p0,p1) = "
     "(max(sq(v1),(p1*A1))/p1); f5(p0,p1) : "
     "grey((.5-1.35)+grey(Pz,.5,.5)+(v1*c2),((.5*0)/Sqrt(c2)),((Pz+1)-abs(0)));",
     "f3(-.5,((3*c2)+(Py/3)),abs)", -2.4038461538461537},
};

/* noise3 and rand lose up to five digits where they jump or divide. */
static void programs_drawn_at_random_agree_with_radiance(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++) {
        struct bench b = bench_of(programs[i].text);
        assert_string_equal(b.message, "");
        bench_reals(&b, 2, (const double[]){1.5, .4});
        bench_near(&b, programs[i].expression, programs[i].value, 1e-9);
        assert_int_equal(b.faults, 0);
        pm_language_free(b.language);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(programs_drawn_at_random_agree_with_radiance),
    };
    return cmocka_run_group_tests_name("language.random", tests, NULL, NULL);
}
