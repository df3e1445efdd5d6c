!> The Level-1 products of GRACE and GRACE-FO: their fields, in one table.
!>
!> Sources: the headers of the GRACE-FO text files (release 04), the GRACE Level 1B Data Product User
!> Handbook (JPL D-22027), and official files, text beside binary. Everything that reads, writes, lists or
!> converts follows from this table: text has the fields in the order given, divided by white space; binary
!> has the same fields packed, most significant byte first.
module gracecg_level1_products
    use gracecg_level1_basics
    use gracecg_base_error, only: fail_unknown_name
    use gracecg_base_text, only: split
    implicit none
    private
    public :: level1_field_t, level1_layout_t, level1_layout, is_level1_product, level1_product_names
    public :: is_calibration_history, satellite_of_grace_fo, SATELLITES, FAMILIES, TITLES
    public :: KIND_I1, KIND_I2, KIND_I4, KIND_U1, KIND_U2, KIND_U4, KIND_F4, KIND_F8, KIND_LETTER, KIND_NUMERAL, &
        KIND_FLAG8, KIND_FLAG32

    !> Kinds of field: signed and unsigned integers by their bytes, reals, one letter, one numeral (binary: its
    !> character), and flags of 8 or 32 bits (text: binary digits, bit 0 rightmost)
    integer, parameter :: KIND_I1 = 1, KIND_I2 = 2, KIND_I4 = 3, KIND_U1 = 4, KIND_U2 = 5, KIND_U4 = 6, &
        KIND_F4 = 7, KIND_F8 = 8, KIND_LETTER = 9, KIND_NUMERAL = 10, KIND_FLAG8 = 11, KIND_FLAG32 = 12
    character(2), parameter :: KIND_NAMES(12) = [character(2) :: 'i1', 'i2', 'i4', 'u1', 'u2', 'u4', 'f4', 'f8', &
                                                 'c', 'n', 'q1', 'q4']
    integer, parameter :: KIND_BYTES(12) = [1, 2, 4, 1, 2, 4, 4, 8, 1, 1, 1, 4]

    character(*), parameter :: SATELLITES = 'ABCD'      !! GRACE A and B, GRACE-FO C and D
    integer, parameter :: MOST_CHANNELS = 32            !! Receiver channels of a GNV1A record: the GPS satellites

    !> What titles of GRACE-FO call the products that begin with these letters; a title that has another one in it is first
    character(3), parameter :: FAMILIES(13) = ['ACT', 'AHK', 'ACC', 'SCA', 'IMU', 'MAG', 'MAS', 'THR', 'TNK', 'CLK', &
                                               'TIM', 'GNI', 'GNV']
    !> What they call them
    character(32), parameter :: TITLES(13) = [character(32) :: &
        'Transformed Accelerometer', 'Accelerometer Housekeeping', 'Accelerometer', 'Star Camera', 'IMU', &
        'Magnetometer and Torque Rod', 'Mass', 'Thruster', 'Tank Temperature and Pressure', 'Clock Offset', 'Clock', &
        'Intermediate GPS Navigation', 'GPS Navigation']

    type :: level1_field_t
        !! One field of a record
        character(16) :: name = ''      !! As in the headers; fractions time_frac, satellites id
        integer :: kind = 0             !! One of KIND_...
        integer :: bytes = 0            !! In a binary record
        integer :: bit = -1             !! Of prod_flag: the field is there when it is set; -1: always there
        integer :: channel = 0          !! Of n_prns: the field is there up to so many; 0: always there
    contains
        procedure :: in_records_of      !! Whether records of a shape have it
    end type level1_field_t

    type :: level1_layout_t
        !! The fields of a product; positions are 0 where a product has no such field
        character(5) :: product = ''    !! 'ACC1A'
        logical :: grace_fo = .false.   !! The form of GRACE-FO, where that differs
        logical :: has_binary = .true.  !! There is a binary form
        logical :: is_event = .false.   !! Records when something happens: there are no gaps
        logical :: keeps_last = .false. !! Of records with equal epochs the last one holds
        type(level1_field_t), allocatable :: fields(:)    !! In the order of a record
        integer :: fraction = 0         !! Position of the fraction of the time tag; its whole seconds are field 1
        integer :: time_frac = 0        !! Position of the fraction of a second: of the tag, or of TIM1B's receiver time
        real(dp) :: fraction_unit = 1e-6_dp     !! Of `time_frac`, s
        integer :: id = 0               !! Position of the satellite
        integer :: time_ref = 0         !! Position of the time frame, R or G
        integer :: prod_flag = 0        !! Position of the flag that says which fields are there
        integer :: channels = 0         !! Position of the number of channels, n_prns
        integer :: shape = 0            !! Position of either: it says which fields a record has
        integer :: series = 0           !! Position of what tells apart series in one file: a head, gyro, tank
        integer :: qualflg = 0          !! Position of the quality flag
        logical :: id_first = .false.   !! Text has the satellite before the time frame
    contains
        procedure :: field_of => position_of_field  !! Position of a field by its name
    end type level1_layout_t

    !> A row of the table: products with the same fields. Flags and series are those of the layout
    type :: row_t
        character(72) :: products = ''      !! Names, blanks between
        character(900) :: fields = ''       !! NAME:KIND[:BIT], NAME*COUNT:KIND, and the channels of GNV1A
        character(9) :: series = ''
        logical :: of_grace = .true., of_grace_fo = .true.      !! Missions that have the product in this form
        logical :: has_binary = .true., is_event = .false., keeps_last = .false., id_first = .false.
    end type row_t

    character(*), parameter :: TAG = 'rcvtime_intg:i4 time_frac:i4 '
    character(*), parameter :: TIME = 'time_intg:i4 time_frac:i4 time_ref:c id:c '
    character(*), parameter :: ATTITUDE = 'quatangle:f8 quaticoeff:f8 quatjcoeff:f8 quatkcoeff:f8 '
    character(*), parameter :: STATE = 'xpos:f8 ypos:f8 zpos:f8 xpos_err:f8 ypos_err:f8 zpos_err:f8 '// &
        'xvel:f8 yvel:f8 zvel:f8 xvel_err:f8 yvel_err:f8 zvel_err:f8 '
    character(*), parameter :: CAMERA = 'nlocks:u1 nstars:u1 sca_confid:i1 sca_null1:i1 sca_null2:i1 sca_mode:q1 qualflg:q1'
    character(*), parameter :: FLAGGED = TAG//'time_ref:c id:c qualflg:q1 prod_flag:q4 '

    character(*), parameter :: ACC1A = FLAGGED// &
        'lin_accl_x:f8:0 lin_accl_y:f8:1 lin_accl_z:f8:2 ang_accl_x:f8:3 ang_accl_y:f8:4 ang_accl_z:f8:5 '// &
        'bias_vol:f8:6 vd:f4:7 x1_out:f4:8 x2_out:f4:9 x3_out:f4:10 y1_out:f4:11 y2_out:f4:12 z1_out:f4:13 '// &
        'tesu:f4:14 taicu:f4:15 tisu:f4:16 v15picu:f4:17 v15micu:f4:18 vr5picu:f4:19 tcicu:f4:20 v15psu:f4:21 '// &
        'v15msu:f4:22 v48psu:f4:23 v48msu:f4:24 status:q1:25 icu_blk_nr:u2:26 Tenhz_count:i1:27 Mhz_count:i4:28 '// &
        'statusflag:q4:29'
    !> What the housekeeping of GRACE-FO has for the values of ACC1A, from bit 0 on
    character(10), parameter :: AHK_GRACE_FO(0:29) = [character(10) :: &
        'TFEEU_IF', 'TFEEU_REF', 'TFEEU_X', 'TFEEU_YZ', 'analog_GND', '+3.3V', 'Vp', 'MES_Vd', 'MES_DET_X1', 'MES_DET_X2', &
        'MES_DET_X3', 'MES_DET_Y1', 'MES_DET_Y2', 'MES_DET_Z1', 'TSU_Y+', 'TICUN', 'TSU_Y-', 'TSU_Z+', 'TSU_Z-', '+5V', &
        'TICUR', '+15V', '-15V', '+48V', '-48V', 'status', 'icu_blk_nr', 'PPS_source', 'Sync_Qual', 'statusflag']
    character(*), parameter :: ACC1B = 'gps_time:i4 id:c lin_accl_x:f8 lin_accl_y:f8 lin_accl_z:f8 ang_accl_x:f8 '// &
        'ang_accl_y:f8 ang_accl_z:f8 acl_x_res:f8 acl_y_res:f8 acl_z_res:f8 qualflg:q1'
    character(*), parameter :: SCA1B = 'gps_time:i4 id:c sca_id:i1 '//ATTITUDE//'qual_rss:f8 qualflg:q1'
    character(*), parameter :: SCA1A_GRACE = 'rcv_time:i4 id:c sca_id:i1 sca_desig:c '//ATTITUDE//CAMERA
    character(*), parameter :: SCA1A_GRACE_FO = TAG//'id:c sca_id:i1 sca_desig:c '//ATTITUDE//CAMERA
    character(*), parameter :: IMU1A = TIME//'gyro_id:i1 FiltAng:f8 qualflg:q1'
    character(*), parameter :: MAG1A = TIME//'MfvX_RAW:f4 MfvY_RAW:f4 MfvZ_RAW:f4 torque1A:f4 torque2A:f4 torque3A:f4 '// &
        'torque1B:f4 torque2B:f4 torque3B:f4 MF_BCalX:f4 MF_BCalY:f4 MF_BCalZ:f4 torque_cal:f4 qualflg:q1'
    character(*), parameter :: THR1A = TIME//'thrust_count_*14:u4 on_time_*14:u4 accum_dur_*14:u4 qualflg:q1'
    character(*), parameter :: TNK1A = TIME//'tank_id:n qualflg:q1 prod_flag:q1 tank_pres:f4:0 reg_pres:f4:1 '// &
        'skin_temp:f4:2 skin_temp_r:f4:3 adap_temp:f4:4 boss_fixed:f4:5 boss_sliding:f4:6'
    character(*), parameter :: MAS1A = TIME//'qualflg:q1 prod_flag:q1 mass_thr:f8:0 mass_thr_err:f8:1 mass_tnk:f8:2 '// &
        'mass_tnk_err:f8:3 gas_mass_thr1:f8:4 gas_mass_thr2:f8:5 gas_mass_tnk1:f8:6 gas_mass_tnk2:f8:7'
    character(*), parameter :: TIM1A = 'obctime:i4 id:c TS_suppid:i4 rcvtime_intg:i4 time_frac:i4 first_icu_blknr:i4 '// &
        'final_icu_blknr:i4 qualflg:q1'
    character(*), parameter :: CLK1A = 'rcv_time:i4 id:c clock_id:i1 eps_time:f8 eps_err:f8 eps_drift:f8 drift_err:f8 '// &
        'qualflg:q1'
    character(*), parameter :: GNV1B = 'gps_time:i4 id:c coord_ref:c '//STATE//'qualflg:q1'
    character(*), parameter :: GNV1A = 'rcv_time:i4 n_prns:i1 id:c chisq:f4 cov_mult:f4 voltage:i2 '//STATE// &
        'time_offset:f8 time_offset_err:f8 time_drift:f8 err_drift:f8 qualflg:q1 CHANNELS:*'
    character(*), parameter :: USO1B = 'gps_time:i4 id:c uso_id:i1 uso_freq:f8 k_freq:f8 ka_freq:f8 qualflg:q1'
    character(*), parameter :: VECTOR = 'gps_time:i4 id:c mag:f8 cosx:f8 cosy:f8 cosz:f8 qualflg:q1'

    type(row_t), parameter :: TABLE(18) = [ &
        row_t('ACC1A ACT1A', ACC1A), &
        row_t('AHK1A AHK1B', ACC1A, series='prod_flag'), &
        row_t('ACC1B ACT1B', ACC1B), &
        row_t('SCA1A', SCA1A_GRACE, series='sca_id', of_grace_fo=.false.), &
        row_t('SCA1A', SCA1A_GRACE_FO, series='sca_id', of_grace=.false., has_binary=.false.), &
        row_t('SCA1B', SCA1B), &
        row_t('QSA1B QKS1B QSB1B QCP1B', SCA1B, series='sca_id', is_event=.true., keeps_last=.true.), &
        row_t('IMU1A IMU1B', IMU1A, series='gyro_id', has_binary=.false.), &
        row_t('MAG1A MAG1B', MAG1A, id_first=.true.), &
        row_t('THR1A THR1B', THR1A, is_event=.true.), &
        row_t('TNK1A TNK1B', TNK1A, series='tank_id'), &
        row_t('MAS1A MAS1B', MAS1A, series='prod_flag'), &
        row_t('TIM1A TIM1B', TIM1A), &
        row_t('CLK1A CLK1B', CLK1A, keeps_last=.true.), &
        row_t('GNV1A', GNV1A), &
        row_t('GNV1B GNI1B', GNV1B), &
        row_t('USO1B', USO1B), &
        row_t('VCM1B VKB1B VGN1B VGB1B VGO1B VSL1B', VECTOR, is_event=.true., keeps_last=.true.)]

contains

    !> The row of a product; 0: there is none.
    pure integer function row_of(product, grace_fo) result(row)
        character(*), intent(in) :: product     !! 'ACC1A'
        logical, intent(in) :: grace_fo

        row = 0
        if (len_trim(product) /= 5 .or. index(trim(product), ' ') > 0) return
        row = findloc(mod(index(TABLE%products, trim(product)), 6) == 1 .and. &
                      merge(TABLE%of_grace_fo, TABLE%of_grace, grace_fo), .true., 1)
    end function row_of

    !> Whether five letters name a product of the table.
    pure logical function is_level1_product(name)
        character(*), intent(in) :: name    !! 'ACC1A'

        is_level1_product = row_of(name, .true.) > 0
    end function is_level1_product

    !> Whether a product is a history of calibrations: its files stand for long times.
    pure logical function is_calibration_history(product)
        character(*), intent(in) :: product     !! 'QSA1B'

        integer :: row

        row = row_of(product, .true.)
        is_calibration_history = .false.
        if (row > 0) is_calibration_history = TABLE(row)%is_event .and. TABLE(row)%keeps_last
    end function is_calibration_history

    !> The names of all products.
    function level1_product_names() result(names)
        character(5), allocatable :: names(:)

        type(string_t), allocatable :: words(:)
        integer :: i, k

        allocate (names(0))
        do i = 1, size(TABLE)
            words = split_words(TABLE(i)%products)
            if (TABLE(i)%of_grace_fo) names = [character(5) :: names, (words(k)%text, k=1, size(words))]
        end do
    end function level1_product_names

    !> Whether a satellite is one of GRACE-FO.
    pure logical function satellite_of_grace_fo(satellite)
        character(1), intent(in) :: satellite   !! One of SATELLITES

        satellite_of_grace_fo = satellite == 'C' .or. satellite == 'D'
    end function satellite_of_grace_fo

    !> The layout of a product. Fails for a name that the table has not.
    subroutine level1_layout(product, grace_fo, layout, error)
        character(*), intent(in) :: product     !! 'ACC1A'
        logical, intent(in) :: grace_fo         !! Of GRACE-FO, not of GRACE
        type(level1_layout_t), intent(out) :: layout
        type(error_t), allocatable, intent(out) :: error

        integer :: row

        row = row_of(product, grace_fo)
        if (row == 0) then
            call fail_unknown_name(error, 'Level-1 product', product, level1_product_names())
            return
        end if
        layout%product = product
        layout%grace_fo = grace_fo
        layout%has_binary = TABLE(row)%has_binary
        layout%is_event = TABLE(row)%is_event
        layout%keeps_last = TABLE(row)%keeps_last
        layout%id_first = TABLE(row)%id_first
        if (product(:3) == 'TIM' .and. grace_fo) layout%fraction_unit = 1e-9_dp
        call describe(layout, TABLE(row)%fields)
        if (layout%fields(2)%name == 'time_frac') layout%fraction = 2
        layout%time_frac = layout%field_of('time_frac')
        layout%id = layout%field_of('id')
        layout%time_ref = layout%field_of('time_ref')
        layout%prod_flag = layout%field_of('prod_flag')
        layout%channels = layout%field_of('n_prns')
        layout%shape = max(layout%prod_flag, layout%channels)
        layout%qualflg = layout%field_of('qualflg')
        layout%series = layout%field_of(trim(TABLE(row)%series))
    end subroutine level1_layout

    !> The fields of a layout from their description.
    subroutine describe(layout, description)
        type(level1_layout_t), intent(inout) :: layout
        character(*), intent(in) :: description     !! As `fields` of a row

        type(string_t), allocatable :: words(:), parts(:)
        integer :: i, k, star, number, bit
        logical :: ok

        words = split_words(description)
        allocate (layout%fields(0))
        do i = 1, size(words)
            parts = split(words(i)%text, ':')
            bit = -1
            if (size(parts) > 2) call parse_integer(parts(3)%text, bit, ok)
            star = index(parts(1)%text, '*')
            if (parts(1)%text == 'CHANNELS') then
                do k = 1, MOST_CHANNELS
                    call add_field('prn_'//integer_text(k), 'i1', k)
                    call add_field('elevation_'//integer_text(k), 'f8', k)
                    call add_field('azimuth_'//integer_text(k), 'f8', k)
                end do
            else if (star > 0) then
                call parse_integer(parts(1)%text(star + 1:), number, ok)
                do k = 1, number
                    call add_field(parts(1)%text(:star - 1)//integer_text(k), parts(2)%text, 0)
                end do
            else
                call add_field(parts(1)%text, parts(2)%text, 0)
            end if
        end do

    contains

        subroutine add_field(name, kind_name, channel)
            character(*), intent(in) :: name, kind_name
            integer, intent(in) :: channel

            integer :: kind

            kind = findloc(KIND_NAMES == kind_name, .true., 1)
            layout%fields = [layout%fields, level1_field_t(name, kind, KIND_BYTES(kind), bit, channel)]
        end subroutine add_field
    end subroutine describe

    !> Whether records of a shape have a field.
    elemental logical function in_records_of(self, shape)
        class(level1_field_t), intent(in) :: self
        integer(i8), intent(in) :: shape    !! Value of the layout's `shape`: bits, or number of channels

        in_records_of = self%channel <= shape
        if (self%bit >= 0) in_records_of = btest(shape, self%bit)
    end function in_records_of

    !> The position of a field; 0 when there is none of that name. The names of some headers are known too:
    !> GRACEFO_id for id, rcvtime_frac for time_frac, those of GRACE-FO's housekeeping for ACC1A's of the same bit.
    pure integer function position_of_field(self, name) result(position)
        class(level1_layout_t), intent(in) :: self
        character(*), intent(in) :: name    !! As `fields%name`

        position = findloc(self%fields%name == name, .true., 1)
        if (position > 0) return
        if (name == 'GRACEFO_id' .or. name == 'GRACE_id') position = self%id
        if (name == 'rcvtime_frac') position = self%time_frac
        if (index(self%product, 'AHK') == 1 .and. self%grace_fo .and. any(AHK_GRACE_FO == name)) &
            position = findloc(self%fields%bit, findloc(AHK_GRACE_FO, name, 1) - 1, 1)
    end function position_of_field
end module gracecg_level1_products
