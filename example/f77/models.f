C     The models one by one, called as a Fortran 77 program calls its
C     routines: no module, REAL*8, INTEGER and arrays only.
C
C        gfortran -std=legacy models.f $(pkg-config --libs gracecg)
C
C     The numbers are those of gracecg model gravity, field, density,
C     wind and sun.
C
      PROGRAM MODELS
      IMPLICIT NONE
      INTEGER MJD, ISTAT, IGRV, IFLD, IDEN, IWND
      REAL*8 SEC, XFIX(3), A(3), U, B(3), RHO, TEMP, XN(3)
      REAL*8 WEAST, WNORTH, XSUN(3)
      CHARACTER*32 VERS
      CHARACTER*400 MSG
C     Where: Earth-fixed, m; when: UTC
      DATA XFIX /4.0D6, -3.0D6, 4.6D6/
C
      CALL GCVERS(VERS)
      WRITE (*, '(2A)') 'gracecg ', VERS
      CALL GCUTC('1989-01-02T06:00:00', MJD, SEC, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
C
C     Open each model once
C
      CALL GCGRVO('egm96', 20, 20, IGRV, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCFLDO('igrf95', MJD, SEC, IFLD, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCDENO(MJD, SEC, IDEN, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCWNDO('hwm93', IWND, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
C
C     Call it as often as needed
C
      CALL GCGRAV(IGRV, XFIX, A, U, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'gravity, m/s^2     ', A
      WRITE (*, 100) 'potential, m^2/s^2 ', U
      CALL GCFELD(IFLD, XFIX, B, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'field, T           ', B
      CALL GCDENS(IDEN, MJD, SEC, XFIX, RHO, TEMP, XN, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'density, kg/m^3    ', RHO
      WRITE (*, 100) 'temperature, K     ', TEMP
      CALL GCWIND(IWND, MJD, SEC, XFIX, WEAST, WNORTH, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'wind E, N, m/s     ', WEAST, WNORTH
      CALL GCSUN(MJD, SEC, XSUN, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      WRITE (*, 100) 'Sun, inertial, m   ', XSUN
C
C     What is wrong is said, and nothing stops
C
      CALL GCFREE(IGRV, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCGRVO('egm96', 99, 99, IGRV, ISTAT, MSG)
      WRITE (*, '(A, I2, 2A)') 'degree 99 gives status', ISTAT, ': ',
     &   MSG(1:70)
C
      CALL GCFREE(IFLD, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCFREE(IDEN, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
      CALL GCFREE(IWND, ISTAT, MSG)
      CALL CHECK(ISTAT, MSG)
  100 FORMAT (A, 1P, 3E22.13)
      END

C     Ends the program after a failure, with the library's message.
C
      SUBROUTINE CHECK(ISTAT, MSG)
      IMPLICIT NONE
      INTEGER ISTAT
      CHARACTER*(*) MSG
      IF (ISTAT .EQ. 0) RETURN
      WRITE (*, '(A, I2, 2A)') 'status', ISTAT, ': ', MSG
      STOP 1
      END
