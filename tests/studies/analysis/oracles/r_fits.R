suppressMessages({library(lme4);library(geepack);library(sandwich);library(jsonlite)})
# Run in this folder: Rscript r_fits.R. The answers are those in r_fits.json itself.
old<-fromJSON('r_fits.json'); d<-as.data.frame(old$data)
ctl<-glmerControl(tolPwrss=1e-13,optimizer='bobyqa',optCtrl=list(rhoend=1e-10))
fm<-function(call,m) list(call=call,terms=names(fixef(m)),estimate=unname(fixef(m)),se=unname(sqrt(diag(as.matrix(vcov(m))))),sd=as.list(setNames(as.data.frame(VarCorr(m))$sdcor,as.data.frame(VarCorr(m))$grp)),logLik=as.numeric(logLik(m)))
fg<-function(call,m) {s<-summary(m)$coefficients; list(call=call,terms=rownames(s),estimate=s[,1],se=s[,2],alpha=unname(m$geese$alpha))}
c1<-"glmer(y ~ left + group + x + (1|subject) + (1|item), d, binomial, control=glmerControl(tolPwrss=1e-13, optimizer='bobyqa', optCtrl=list(rhoend=1e-10)))"
m1<-glmer(y ~ left + group + x + (1|subject) + (1|item), d, binomial, control=ctl)
m2<-glmer(y ~ 1 + (1|subject), d, binomial, control=ctl)
m3<-glmer(y ~ x + (1|subject) + (1|item) + (1|third), d, binomial, control=ctl)
d<-d[order(d$subject),]
g1<-geeglm(y~left+group+x,id=subject,data=d,family=binomial,corstr='exchangeable',control=geese.control(epsilon=1e-10,maxit=200))
g2<-geeglm(y~left+group+x,id=subject,data=d,family=binomial,corstr='independence',control=geese.control(epsilon=1e-10,maxit=200))
l<-lm(y~1,d)
v<-function(cl) as.numeric(vcovCL(l,cluster=cl,type='HC0',cadjust=TRUE,multi0=FALSE))
cell<-lm(y~0+factor(left),d); 
ms<-c('a','b','c','d'); X<-sapply(ms[-1],function(k)(d$first==k)-(d$second==k)); bt<-glm(d$won~0+X,family=binomial)
bt2<-vcovCL(bt,cluster=d$subject,type='HC0',cadjust=TRUE)
d<-d[order(d$subject,d$item),]
out<-list(desc='24 subjects, 10 items, answers made up; R 4.2.2, lme4, geepack, sandwich of Debian 12',
 versions=list(lme4=as.character(packageVersion('lme4')),geepack=as.character(packageVersion('geepack')),sandwich=as.character(packageVersion('sandwich'))),
 data=as.list(d[,c('subject','item','left','group','x','y','third','first','second','won')]),
 glmer=list(fm(c1,m1),fm(sub('left \\+ group \\+ x','1',sub(' \\+ \\(1\\|item\\)','',c1)),m2),fm(sub('left \\+ group \\+ x','x',sub('\\(1\\|item\\)','(1|item) + (1|third)',c1)),m3)),
 geeglm=list(fg("geeglm(y ~ left + group + x, id=subject, data=d, family=binomial, corstr='exchangeable', control=geese.control(epsilon=1e-10, maxit=200))",g1),fg("geeglm(y ~ left + group + x, id=subject, data=d, family=binomial, corstr='independence', control=geese.control(epsilon=1e-10, maxit=200))",g2)),
 variance=list(call="vcovCL(lm(y ~ 1, d), cluster=..., type='HC0', cadjust=TRUE, multi0=FALSE)",subject=v(d$subject),item=v(d$item),both=v(d[,c('subject','item')])),
 cells=list(call="vcovCL(lm(y ~ 0 + factor(left), d), cluster=~subject, type='HC0', cadjust=TRUE)",mean=unname(coef(cell)),covariance=unname(vcovCL(cell,cluster=d$subject,type='HC0',cadjust=TRUE))),
 bradley_terry=list(call="glm(won ~ 0 + X, binomial), X = indicators of first less second; vcovCL(., cluster=subject, type='HC0', cadjust=TRUE)",against_a=unname(coef(bt)),covariance=unname(bt2)))
write(toJSON(out,digits=12,auto_unbox=TRUE,pretty=FALSE),'r_fits.json')
